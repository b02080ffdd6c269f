#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Root of the area-weighted mean of B^2 over the samples, each divided by its chance.
layout(local_size_x = GROUP_SIZE) in;
layout(constant_id = 0) const uint CHANNELS = 7;
READS(object_params)
READS(leaves)
READS(clusters)
READS(samples)
UPDATES(reference_level)
#include "transport/blocks/channels.glsl"

shared vec3 sums[GROUP_SIZE];

// What a sample adds: its square by its share, relative to the largest value and the mean area, so that squares neither
// overflow nor underflow.
vec3 term(Sample one, vec3 most, float mean) {
    vec3 value = one.value / most;
    float share = mean > 0.0 ? clusters[leaves[one.face]].area / mean : 0.0;
    return value * value * (share / (one.chance * float(object_params[0].faces)));
}

void main() {
    // Four samples an invocation, all loaded at once.
    uint self = gl_LocalInvocationIndex;
    Sample one = samples[self], two = samples[self + GROUP_SIZE];
    Sample three = samples[self + 2 * GROUP_SIZE], four = samples[self + 3 * GROUP_SIZE];
    sums[self] = max(max(max(max(vec3(1e-30), one.value), two.value), three.value), four.value);
    barrier();
    for (uint step = GROUP_SIZE / 2; step > 0; step /= 2) {
        if (self < step) sums[self] = max(sums[self], sums[self + step]);
        barrier();
    }
    vec3 most = sums[0];
    barrier();
    float mean = clusters[0].area / float(object_params[0].faces);
    sums[self] = term(one, most, mean) + term(two, most, mean) + term(three, most, mean) + term(four, most, mean);
    barrier();
    for (uint step = GROUP_SIZE / 2; step > 0; step /= 2) {
        if (self < step) sums[self] += sums[self + step];
        barrier();
    }
    if (self == 0) reference_level[0] = only_group(max(most * sqrt(sums[0] / float(COARSE_SAMPLES)), vec3(1e-30)), reference_level[0]);
}
