// Uniform point samples of a triangle: how many, and where. These are decisions, so they are exact: one product, and
// integers.
const uint ONE = 1u << SAMPLE_BITS;

// One sample for each disc whose radius is a mean free path.
uint sample_count(float area, float density) {
    precise float wanted = area * density;
    return wanted < float(MOST_SAMPLES) ? max(uint(ceil(wanted)), 1) : MOST_SAMPLES;
}

// A hash: each of its bits depends on every bit of x.
uint mixed(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

// Barycentric coordinates of sample k of a face; a single sample stands at the centroid.
vec3 sample_place(uint face, uint k, uint count) {
    if (count == 1) return vec3(1.0 / 3.0);
    uint first = mixed(mixed(face) ^ k);
    uint a = first >> 32 - SAMPLE_BITS, b = mixed(first ^ 0x9e3779b9u) >> 32 - SAMPLE_BITS;
    if (a + b > ONE) {
        a = ONE - a;
        b = ONE - b;
    }
    return vec3(a, b, ONE - a - b) / float(ONE);
}
