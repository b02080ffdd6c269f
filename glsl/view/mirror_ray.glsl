// Rays to the environment from a surface that reflects it, drawn from the lobe in which it mirrors the eye, or from
// where the environment is bright: other ones in each pixel and sample. Additions, multiplications and comparisons
// only: the same bits on every device.

// A point of the surface, as the eye sees it.
struct Seen {
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
    return Seen(outside ? normal : -normal, unit_of(toward), plane, outside);
}

// Whether this ray is to be traced. Where the interpolated normal sends it below the triangle, and on a side that is
// seen from inside, it counts as free.
bool traced(Seen seen, Light light) {
    return seen.outside && dot3(light.place, seen.plane) > 0.0;
}

// alpha^2 - 1 of the microfacets whose distribution is nearest to Phong's lobe of this exponent m, where alpha^2 is
// 4 / (m + 3).
float narrowing(float exponent) {
    precise float least = 4.0 * inverse_of(exponent + 3.0) - 1.0;
    return least;
}

// A microfacet as the eye sees it, from a point of the unit square: by spherical caps (Dupuy and Benyoub 2023). `local`
// is the direction to the eye, in the frame of the normal.
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

// A place of the octahedron's upper half on the lower one, and back.
vec2 folded(vec2 place) {
    precise vec2 across = 1.0 - abs(place.yx);
    return vec2(place.x < 0.0 ? -across.x : across.x, place.y < 0.0 ? -across.y : across.y);
}

// The cell of the octahedral map in which a direction lies: x and y of the octahedron |x| + |y| + |z| = 1, its lower
// half folded outwards.
uint cell_of(vec3 way) {
    precise float sum = abs(way.x) + abs(way.y) + abs(way.z);
    float by = inverse_of(sum);
    precise vec2 place = way.xy * by;
    if (way.z < 0.0) place = folded(place);
    precise vec2 cell = clamp((place * 0.5 + 0.5) * float(SKY_CELLS), 0.0, float(SKY_CELLS - 1));
    return uint(cell.y) * SKY_CELLS + uint(cell.x);
}

// The direction to a place in a cell that is drawn by the alias method.
vec3 bright(Light light, uint pixel) {
    uint point = camera[0].sample_number * light.of + light.number;
    uint cell = (random4(pixel, light.kind, 0, 0).x + point * SQUARE_STEPS[0]) >> 16;
    uvec4 bits = random4(pixel, light.kind, point, 1);
    SkyCell drawn = sky_cells[cell];
    if (bits.z >> 16 >= drawn.kept) cell = drawn.other;
    vec2 within = vec2(unit_random(bits.x), unit_random(bits.y));
    precise vec2 place = (vec2(cell % SKY_CELLS, cell / SKY_CELLS) + within) * (2.0 / float(SKY_CELLS)) - 1.0;
    precise float z = 1.0 - abs(place.x) - abs(place.y);
    if (z < 0.0) place = folded(place);
    return unit_of(vec3(place, z));
}

// The shape of the lobe from which a pixel draws this ray.
float drawn_shape(Light light, uint pixel, uint object) {
    float share = object_params[object].second_share;
    if (share == 0.0) return object_params[object].roughness;
    uint point = camera[0].sample_number * light.of + light.number;
    bool second = unit_random(random4(pixel, light.kind, point, 2).x) < share;
    return second ? object_params[object].second_roughness : object_params[object].roughness;
}

// The ray to the environment that stands for this record in a pixel; its place is the direction, about unit length.
Light mirror_ray(Light light, uint pixel, Seen seen, float shape, bool ggx) {
    vec2 square = square_point(light, pixel);
    float along = dot3(seen.normal, seen.eye);
    vec3 way;
    if (light.kind == LIGHT_BRIGHT_RAY) {
        way = bright(light, pixel);
    } else if (ggx) {
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
