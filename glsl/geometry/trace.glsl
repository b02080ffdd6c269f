// The nearest triangle along a ray, by the tree of the scene.
#include "geometry/sight.glsl"

Nearest trace(vec3 origin, vec3 direction) {
    Nearest nearest = Nearest(NONE, vec3(0), 0.0, 1.0);
    Sight ray = sight(direction);
    uint node = 0, end = object_params[0].scene_nodes;
    while (node < end) {
        Bounds box = placed_bounds[node];
        bool met = meets(box.low, box.high, origin, ray, nearest), leaf = box.face != NONE;
        if (met && leaf) {
            uvec3 corner = triangles[box.face];
            precise vec3 a = placed_positions[corner.x] - origin;
            precise vec3 b = placed_positions[corner.y] - origin;
            precise vec3 c = placed_positions[corner.z] - origin;
            Nearest found = pierce(ray, a, b, c);
            precise float mine = found.numerator * nearest.denominator;
            precise float its = nearest.numerator * found.denominator;
            bool nearer = nearest.face == NONE || mine < its || (mine == its && box.face < nearest.face);
            if (found.face != NONE && found.numerator > 0.0 && nearer) {
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
