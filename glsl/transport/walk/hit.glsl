// Where a photon's flight meets the surface of its object.

// From `origin` along the unit `way` for a distance of `path`: the triangle, NONE if the flight ends before one, or
// UNFINISHED if it meets no way out; and weights of the triangle's corners, not normalised.
//
// A triangle is passed outward where its normal is along the way. Rounding may put the origin just outside: triangles
// that are passed outward count from a little below it, others from a little above, and are no way out. A flat triangle
// is not met by a flight `from` it.
uint meeting(vec3 origin, vec3 way, float path, uint from, out vec3 weights) {
    Sight ray = sight(way);
    vec3 m = abs(ray.along);
    float main_part = m.z >= max(m.x, m.y) ? ray.along.z : m.x >= m.y ? ray.along.x : ray.along.y;
    precise float limit = ray.square * path;
    Nearest nearest = Nearest(NONE - 1u, vec3(0), limit, ray.scale);
    bool out_there = true;
    uint node = 0, end = object_params[0].nodes, base = object_params[0].first_node;
    uint first = object_params[0].first_face;
    while (node < end) {
        Bounds box = bounds[node];
        bool met = meets(box.low, box.high, origin, ray, nearest), leaf = box.face != NONE;
        if (met && leaf) {
            uvec3 corner = triangles[box.face - first];
            vec3 pa = positions[corner.x], pb = positions[corner.y], pc = positions[corner.z];
            precise vec3 a = pa - origin;
            precise vec3 b = pb - origin;
            precise vec3 c = pc - origin;
            precise vec3 right = pb - pa;
            precise vec3 up = pc - pa;
            vec3 normal = cross3(right, up), size = abs(normal);
            Nearest found = pierce(ray, a, b, c);
            precise float sum = found.weights.x + found.weights.y + found.weights.z;
            bool outward = (sum > 0.0) == (main_part > 0.0);
            precise float mine = found.numerator * nearest.denominator;
            precise float its = nearest.numerator * found.denominator;
            // Of two at the same distance, as at an edge, a way out counts, else the lower number.
            bool better = outward != out_there ? outward : box.face < nearest.face;
            bool nearer = mine < its || (mine == its && better);
            // The origin's depth below the plane, and how much of it rounding explains.
            precise float least = WALK_MARGIN * (size.x + size.y + size.z);
            float depth = dot3(a, normal);
            bool counts = found.face != NONE && box.face - first != from &&
                          (outward ? found.numerator > 0.0 || depth > -least : found.numerator > 0.0 && depth < -least);
            if (counts && nearer) {
                nearest = found;
                nearest.face = box.face;
                out_there = outward;
            }
        }
        node = met && !leaf ? node + 1 : box.next - base;
    }
    bool lost = node < end || !out_there;
    bool free = nearest.face == NONE - 1u;
    weights = nearest.weights;
    return lost ? UNFINISHED : free ? NONE : nearest.face - first;
}
