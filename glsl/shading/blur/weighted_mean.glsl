// The mean along a texel's row (AXIS 0) or column (AXIS 1), weighted by a Gaussian; FETCH(k) reads texel k.
layout(push_constant, scalar) uniform push_block { uint number, level; };
READS(unwrappings)
READS(texel_hits)
READS(stretch)
READS(gaussians)

vec4 mean(Unwrapping own, uint k) {
    if (texel_hits[own.first + k].face == NONE) return vec4(0);
    int side = int(own.side), at = AXIS == 0 ? int(k % own.side) : int(k / own.side);
    uint rest = AXIS == 0 ? k - uint(at) : k % own.side;
    bool round = own.round[AXIS] != 0;
    precise float length_here = stretch[own.first + k][AXIS], deviation = gaussians[GAUSSIANS * number + level].w;

    // The stride between taps, and the number of taps on each side: decisions, by powers of two times a texel's length.
    const vec4 POWERS = vec4(1, 2, 4, 8);
    vec4 near = POWERS * length_here;
    vec4 few = step(32.0 * POWERS, vec4(side - 1)), many = step(512.0 * POWERS, vec4(side - 1));
    vec4 doubled = few * vec4(greaterThan(vec4(deviation), 8.0 * near));
    doubled += many * vec4(greaterThan(vec4(deviation), 128.0 * near));
    int pace = 1 << int(doubled.x + doubled.y + doubled.z + doubled.w);
    vec4 farther = vec4(greaterThan(vec4(deviation), float(pace) * near));
    int reach = int(BLUR_REACH) << int(farther.x + farther.y + farther.z);

    // Root of the Gaussian's exponent, per tap.
    float rate = 0.84932180 * float(pace) * length_here / deviation;
    vec4 sum = vec4(0);
    int tap = -reach, place = at + tap * pace, turn = round ? side : 0;
    if (round) place -= side * int(floor(float(place) / float(side)));
    // Rounding may leave the place one side off.
    if (round) place = place < 0 ? place + side : place >= side ? place - side : place;
    do {
        float distance = float(tap) * rate, weight = exp2(-distance * distance);
        bool there = place >= 0 && place < side;
        uint other = uint(clamp(place, 0, side - 1));
        vec4 light = FETCH(AXIS == 0 ? rest + other : rest + other * own.side);
        sum += there ? weight * light : vec4(0);
        place += pace;
        place -= place >= side ? turn : 0;
    } while (++tap <= reach);
    return vec4(sum.rgb / sum.a, 1.0);
}
