// The nearest triangle along a ray, by the tree of the scene.
#include "geometry/sight.glsl"

// The rounding error of a product: exact for products above 1e-24.
float lost(float a, float b, float product) {
    precise float split_a = 4097.0 * a, split_b = 4097.0 * b;
    precise float high_a = split_a - (split_a - a), high_b = split_b - (split_b - b);
    precise float low_a = a - high_a, low_b = b - high_b;
    precise float rest = ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
    return rest;
}

// The nearer of the nearest hit so far and a hit on this triangle, if there is one. Fractions are compared exactly; of
// equal ones the triangle with the lower number counts: so the order in which triangles come does not matter.
Nearest nearer(Nearest nearest, Sight ray, vec3 origin, uint face, vec3 corner_a, vec3 corner_b, vec3 corner_c) {
    precise vec3 a = corner_a - origin;
    precise vec3 b = corner_b - origin;
    precise vec3 c = corner_c - origin;
    Nearest found = pierce(ray, a, b, c);
    // The fraction over a denominator of 1 to 2, so that the products of tiny triangles are not too small.
    float scale = uintBitsToFloat(0x7f000000u - (floatBitsToUint(found.denominator) & 0x7f800000u));
    found.numerator *= scale;
    found.denominator *= scale;
    precise float mine = found.numerator * nearest.denominator;
    precise float its = nearest.numerator * found.denominator;
    float my_rest = lost(found.numerator, nearest.denominator, mine);
    float its_rest = lost(nearest.numerator, found.denominator, its);
    bool before = mine < its || (mine == its && (my_rest < its_rest || (my_rest == its_rest && face < nearest.face)));
    bool counts = found.face != NONE && found.numerator > 0.0 && (nearest.face == NONE || before);
    found.face = face;
    if (counts) nearest = found;
    return nearest;
}

// The hit with its distance in multiples of the ray's direction.
Nearest along_ray(Nearest nearest, Sight ray) {
    precise float numerator = nearest.numerator * ray.scale, denominator = nearest.denominator * ray.square;
    return Nearest(nearest.face, nearest.weights, numerator, denominator);
}

Nearest trace(vec3 origin, vec3 direction) {
    Nearest nearest = Nearest(NONE, vec3(0), 0.0, 1.0);
    Sight ray = sight(direction);
    uint node = 0, end = object_params[0].scene_nodes;
    while (node < end) {
        Bounds box = placed_bounds[node];
        bool met = meets(box.low, box.high, origin, ray, nearest), leaf = box.face != NONE;
        if (met && leaf) {
            uvec3 corner = triangles[box.face];
            nearest = nearer(nearest, ray, origin, box.face, placed_positions[corner.x], placed_positions[corner.y],
                             placed_positions[corner.z]);
        }
        node = met && !leaf ? node + 1 : box.next;
    }
    if (node < end) nearest.face = UNFINISHED;
    return along_ray(nearest, ray);
}
