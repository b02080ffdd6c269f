// Rays to the environment from a surface that reflects it, drawn from the lobe in which it mirrors the eye: other ones in
// each pixel and sample. Additions, multiplications and comparisons only: the same bits on every device.

// A point of the surface, as the eye sees it.
struct Seen {
    vec3 place;
    vec3 normal; // the unit interpolated normal, on the side of the triangle that is seen
    vec3 eye;    // the unit direction to the eye
    vec3 plane;  // the triangle's normal; its length is twice the area
    bool outside; // whether the eye is on the side that this normal points to
};

Seen seen_at(Hit hit, uint face) {
    uvec3 corner = triangles[face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    precise vec3 place = BLEND_AT(weight, placed_positions, corner);
    precise vec3 blended = BLEND_AT(weight, placed_normals, corner);
    precise vec3 toward = camera[0].origin - place;
    vec3 plane = plane_of(placed_positions[corner.x], placed_positions[corner.y], placed_positions[corner.z]).normal;
    bool outside = dot3(toward, plane) >= 0.0;
    vec3 normal = unit_of(blended);
    return Seen(place, outside ? normal : -normal, unit_of(toward), plane, outside);
}

// Whether this ray is to be traced. Where the interpolated normal sends it below the triangle, and on a side that is seen
// from inside, it counts as free.
bool traced(Seen seen, Light light) {
    return seen.outside && dot3(light.place, seen.plane) > 0.0;
}

// alpha^2 - 1 of the microfacets whose distribution is nearest to Phong's lobe of this exponent: alpha^2 = 4 / (m + 3).
float narrowing(float exponent) {
    precise float least = 4.0 * inverse_of(exponent + 3.0) - 1.0;
    return least;
}

// A microfacet as the eye sees it, from a point of the unit square: by spherical caps (Dupuy and Benyoub 2023). `local` is
// the direction to the eye, in the frame of the normal.
vec3 facet_seen(vec2 square, vec3 local, float alpha) {
    precise vec3 bent = vec3(alpha * local.x, alpha * local.y, local.z);
    vec3 stretched = unit_of(bent);
    precise float rise = (1.0 - square.x) * (1.0 + stretched.z);
    precise float cosine = rise - stretched.z;
    precise float rest = 1.0 - cosine * cosine;
    float across = root_of(rest);
    vec2 sc = turn(square.y);
    precise vec3 facet = vec3(alpha * (across * sc.y + stretched.x), alpha * (across * sc.x + stretched.y), rise);
    return unit_of(facet);
}

// The ray to the environment that stands for this record in a pixel; its place is the direction, about unit length.
Light mirror_ray(Light light, uint pixel, Seen seen, float shape, bool ggx) {
    vec2 square = square_point(light, pixel);
    float along = dot3(seen.normal, seen.eye);
    vec3 way;
    if (ggx) {
        vec3 right, up;
        across_axis(seen.normal, right, up);
        vec3 local = vec3(dot3(right, seen.eye), dot3(up, seen.eye), abs(along));
        vec3 facet = facet_seen(square, local, shape);
        float met = dot3(local, facet);
        precise vec3 mirrored = 2.0 * met * facet - local;
        precise vec3 turned = mirrored.x * right + mirrored.y * up + mirrored.z * seen.normal;
        way = turned;
    } else {
        precise vec3 mirror = 2.0 * along * seen.normal - seen.eye;
        precise float spread = 1.0 + narrowing(shape) * square.x;
        precise float square_cosine = (1.0 - square.x) * inverse_of(spread);
        way = about(kept_unit(mirror), root_of(square_cosine), square.y);
    }
    light.kind = LIGHT_SKY_RAY;
    light.place = way;
    return light;
}
