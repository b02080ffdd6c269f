// Arithmetic of the walk: additions, multiplications and comparisons only, so that every device finds the same bits.
#include "geometry/exact.glsl"

// Four random numbers of a photon's flight: pcg4d of Jarzynski and Olano 2020.
uvec4 random4(uint number, uint flight, uint channel, uint seed) {
    uvec4 v = uvec4(number, flight, channel, seed) * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

// One of 2^23 numbers in (0, 1).
float unit_random(uint bits) {
    precise float x = float((bits >> 9) * 2u + 1u) * (1.0 / 16777216.0);
    return x;
}

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

// The direction that has these cosine and azimuth (in turns) about an axis.
vec3 about(vec3 axis, float cosine, float turns) {
    float s = axis.z >= 0.0 ? 1.0 : -1.0;
    precise float a = -s * inverse_of(1.0 + s * axis.z);
    precise float b = axis.x * axis.y * a;
    precise vec3 right = vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x);
    precise vec3 up = vec3(b, s + axis.y * axis.y * a, -axis.y);
    precise float square = 1.0 - cosine * cosine;
    float across = root_of(square);
    vec2 sc = turn(turns);
    precise vec3 way = cosine * axis + across * (sc.y * right + sc.x * up);
    return way;
}

// Fresnel transmittance of a boundary with this index, inner over outer, from its cosines outside and inside.
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
