// Roots, quotients and refraction in additions, multiplications and comparisons: the same bits on every device.

// 1 / x for x above 0, to 1e-7.
float inverse_of(float x) {
    precise float y = uintBitsToFloat(0x7ef311c7u - floatBitsToUint(x));
    y = y * (2.0 - x * y);
    y = y * (2.0 - x * y);
    y = y * (2.0 - x * y);
    return y;
}

// Square root, to 2e-7; 0 for numbers up to 1e-30.
float root_of(float x) {
    precise float h = 0.5 * x;
    precise float y = uintBitsToFloat(0x5f375a86u - (floatBitsToUint(x) >> 1));
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    precise float root = x * y;
    return x > 1e-30 ? root : 0.0;
}

// A vector scaled to unit length.
vec3 unit_of(vec3 v) {
    float inverse = inverse_of(root_of(dot3(v, v)));
    precise vec3 unit = v * inverse;
    return unit;
}

// A vector of nearly unit length, brought nearer to it.
vec3 kept_unit(vec3 v) {
    float square = dot3(v, v);
    precise float factor = 1.5 - 0.5 * square;
    precise vec3 unit = v * factor;
    return unit;
}

// The cosine inside for one outside; 0 where nothing passes.
float inside_of(float eta, float outer) {
    precise float square = 1.0 - (1.0 - outer * outer) * inverse_of(eta * eta);
    return eta == 1.0 ? outer : root_of(square);
}

// The direction inside of light from `toward`; both unit, `normal` out of the medium.
vec3 refracted(float eta, vec3 toward, vec3 normal) {
    float outer = dot3(toward, normal), by = eta == 1.0 ? 1.0 : inverse_of(eta);
    precise float along = outer * by - inside_of(eta, outer);
    precise vec3 way = along * normal - by * toward;
    return kept_unit(kept_unit(way));
}
