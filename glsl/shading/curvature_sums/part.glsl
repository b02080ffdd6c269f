// The share of a vertex's measures that each of its triangles takes: area, integral of H, integral of K. The vertex
// counts from the object's first. The includer reads `curvature` and `corner_starts`.
vec3 part_of(uint vertex) {
    Curvature bend = curvature[vertex];
    float share = bend.area / float(corner_starts[vertex + 1] - corner_starts[vertex]);
    return share * vec3(1.0, bend.mean, bend.gaussian);
}
