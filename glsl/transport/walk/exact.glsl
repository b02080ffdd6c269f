// Arithmetic of the walk: additions, multiplications and comparisons only, so that every device finds the same bits.
#include "geometry/exact.glsl"
#include "geometry/random.glsl"

// -ln x for x in (0, 1).
float minus_log(float x) {
    uint apart = floatBitsToUint(x) - 0x3f3504f3u;
    precise float e = float(int(apart) >> 23);
    precise float t = uintBitsToFloat((apart & 0x007fffffu) + 0x3f3504f3u) - 1.0;
    precise float sum = LOGARITHM[8];
    sum = sum * t + LOGARITHM[7];
    sum = sum * t + LOGARITHM[6];
    sum = sum * t + LOGARITHM[5];
    sum = sum * t + LOGARITHM[4];
    sum = sum * t + LOGARITHM[3];
    sum = sum * t + LOGARITHM[2];
    sum = sum * t + LOGARITHM[1];
    sum = sum * t + LOGARITHM[0];
    precise float z = t * t;
    precise float log = t * z * sum - 0.5 * z + t + e * 0.69314718;
    return -log;
}

// Fresnel transmittance of a boundary with this relative index, inner over outer, from the cosines outside and inside.
float passes(float eta, float outer, float inner) {
    precise float s = outer + eta * inner;
    precise float p = eta * outer + inner;
    float by_s = inverse_of(max(s, 1e-6)), by_p = inverse_of(max(p, 1e-6));
    precise float sum = outer * by_s * (inner * by_s) + outer * by_p * (inner * by_p);
    precise float share = 2.0 * eta * sum;
    return eta == 1.0 ? 1.0 : outer > 0.0 && inner > 0.0 ? min(share, 1.0) : 0.0;
}

// The cosine outside for one inside; 0 where nothing passes.
float outside_of(float eta, float inner) {
    precise float square = 1.0 - eta * eta * (1.0 - inner * inner);
    return eta == 1.0 ? inner : root_of(square);
}
