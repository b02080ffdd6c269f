// The form factor of a cluster: the polygon that its triangles make on the plane through `center`, across `normal`
// (section 5.1.1), by the edges of its border. The includer reads positions and border_edges, and includes `edge.glsl`.

// An end of an edge, relative to the receiver's foot on the plane.
vec3 projected(uint vertex, vec3 receiver, vec3 normal) {
    vec3 p = positions[vertex] - receiver;
    return p - dot(p, normal) * normal;
}

// J of the polygon for the sources at heights `real` and `virt`, weighted by the depths of both.
vec3 polygon_form(uint first, uint count, vec3 receiver, vec3 normal, vec3 sigma, vec3 real, vec3 virt,
                  vec3 z_real, vec3 z_virtual) {
    // How often the border winds around the foot, and how near it comes.
    vec3 right = normalize(abs(normal.x) < 0.5 ? vec3(0, normal.z, -normal.y) : vec3(-normal.z, 0, normal.x));
    vec3 up = cross(normal, right);
    int winding = 0;
    float nearest = 1e30;
    for (uint e = first; e < first + count; ++e) {
        uvec2 edge = border_edges[e];
        vec3 p = projected(edge.x, receiver, normal), q = projected(edge.y, receiver, normal);
        vec2 from = vec2(dot(p, right), dot(p, up)), to = vec2(dot(q, right), dot(q, up));
        float left = from.x * to.y - to.x * from.y;
        winding += int(from.y <= 0.0 && to.y > 0.0 && left > 0.0) - int(from.y > 0.0 && to.y <= 0.0 && left < 0.0);
        nearest = min(nearest, segment_distance(p, q));
    }
    float rim = winding != 0 ? 0.0 : nearest;
    vec3 real_m = mix(real, sqrt(real * real + rim * rim), lessThan(real, vec3(rim)));
    vec3 virt_m = mix(virt, sqrt(virt * virt + rim * rim), lessThan(virt, vec3(rim)));

    vec3 of_real = vec3(0), of_virt = vec3(0);
    for (uint e = first; e < first + count; ++e) {
        uvec2 edge = border_edges[e];
        vec3 p = projected(edge.x, receiver, normal), q = projected(edge.y, receiver, normal);
        float size = length(q - p);
        vec3 u = size > 0.0 ? (q - p) / size : vec3(0);
        float R = dot(cross(p, u), normal);
        of_real += edge_integral(sigma, R, dot(p, u), dot(q, u), real, rim, real_m);
        of_virt += edge_integral(sigma, R, dot(p, u), dot(q, u), virt, rim, virt_m);
    }
    vec3 sum = z_real * (exp(-sigma * real_m) / real_m) * of_real + z_virtual * (exp(-sigma * virt_m) / virt_m) * of_virt;
    // The sum may be negative where the cluster folds over, or where only rounding is left.
    return mix(sum, vec3(0), lessThan(sum, vec3(0)));
}
