// Where a ray leaves its object: the nearest triangle that it passes outward. Decisions only.

// Rounding may put the origin just outside, so triangles count from a little behind it. The distance is
// numerator / denominator, in multiples of `direction`.
Nearest leaving(uint object, vec3 origin, vec3 direction) {
    Nearest nearest = Nearest(NONE, vec3(0), 0.0, 1.0);
    Sight ray = sight(direction);
    uint node = object_params[object].first_node, end = object_params[object].next_node;
    while (node < end) {
        Bounds box = placed_bounds[node];
        bool met = meets(box.low, box.high, origin, ray, nearest), leaf = box.face != NONE;
        if (met && leaf) {
            uvec3 corner = triangles[box.face];
            vec3 pa = placed_positions[corner.x], pb = placed_positions[corner.y], pc = placed_positions[corner.z];
            precise vec3 a = pa - origin;
            precise vec3 b = pb - origin;
            precise vec3 c = pc - origin;
            precise vec3 right = pb - pa;
            precise vec3 up = pc - pa;
            vec3 normal = cross3(right, up), size = abs(normal);
            Nearest found = pierce(ray, a, b, c);
            precise float mine = found.numerator * nearest.denominator;
            precise float its = nearest.numerator * found.denominator;
            bool nearer = nearest.face == NONE || mine < its || (mine == its && box.face < nearest.face);
            // The origin counts as inside if it is no farther above the plane than rounding explains.
            precise float least = SINGLE_MARGIN * (size.x + size.y + size.z);
            bool inside = found.numerator > 0.0 || dot3(a, normal) > -least;
            if (found.face != NONE && inside && dot3(direction, normal) > 0.0 && nearer) {
                nearest = found;
                nearest.face = box.face;
            }
        }
        node = met && !leaf ? node + 1 : box.next;
    }
    if (node < end) nearest.face = UNFINISHED;
    precise float numerator = nearest.numerator * ray.scale, denominator = nearest.denominator * ray.square;
    return Nearest(nearest.face, nearest.weights, numerator, denominator);
}
