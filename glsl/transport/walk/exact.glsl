// Arithmetic of the walk: additions, multiplications and comparisons only, so that every device finds the same bits.

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

// 1 / x for x above 0, to 1e-7.
float inverse_of(float x) {
    precise float y = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(x));
    y = y * (2.0 - x * y);
    y = y * (2.0 - x * y);
    y = y * (2.0 - x * y);
    return y;
}

// Square root, to 2e-7; 0 of numbers below 1e-30.
float root_of(float x) {
    precise float h = 0.5 * x;
    precise float y = uintBitsToFloat(0x5f375a86u - (floatBitsToUint(x) >> 1));
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    precise float root = x * y;
    return x > 1e-30 ? root : 0.0;
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

// A vector scaled to unit length, and one of nearly unit length made more so.
vec3 unit_of(vec3 v) {
    float inverse = inverse_of(root_of(dot3(v, v)));
    precise vec3 unit = v * inverse;
    return unit;
}

vec3 kept_unit(vec3 v) {
    float square = dot3(v, v);
    precise float factor = 1.5 - 0.5 * square;
    precise vec3 unit = v * factor;
    return unit;
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

// The cosine inside for one outside, and the other way round; 0 where nothing passes.
float inside_of(float eta, float outer) {
    precise float square = 1.0 - (1.0 - outer * outer) * inverse_of(eta * eta);
    return eta == 1.0 ? outer : root_of(square);
}

float outside_of(float eta, float inner) {
    precise float square = 1.0 - eta * eta * (1.0 - inner * inner);
    return eta == 1.0 ? inner : root_of(square);
}

// The direction inside of light from `toward`; both unit, `normal` out of the medium.
vec3 refracted(float eta, vec3 toward, vec3 normal) {
    float outer = dot3(toward, normal), by = eta == 1.0 ? 1.0 : inverse_of(eta);
    precise float along = outer * by - inside_of(eta, outer);
    precise vec3 way = along * normal - by * toward;
    return kept_unit(kept_unit(way));
}
