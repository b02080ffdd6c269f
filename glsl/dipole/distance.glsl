// Squared distance from a receiver to one of the two sources of the dipole of a point of a plane, per channel: the real
// one, below the plane, for side 1, the virtual one, above it, for side -1. `d` runs from that point to the receiver,
// `n` is the plane's unit normal.
layout(constant_id = 0) const uint TABLE1 = 0;

// Radial: s^2 = |d|^2 + z^2. Table 1: the sources are displaced along the normal; heights no less than z.
vec3 source2(vec3 d, vec3 n, vec3 z, float side) {
    float d2 = dot(d, d);
    if (TABLE1 == 0) return d2 + z * z;
    float height = dot(d, n);
    vec3 h = max(abs(height + side * z), z);
    return max(0.0, d2 - height * height) + h * h;
}

// The distance of the same source from a receiver straight above the point, at this height over the plane.
vec3 source_height(float height, vec3 z, float side) {
    return TABLE1 == 0 ? sqrt(height * height + z * z) : max(abs(height + side * z), z);
}
