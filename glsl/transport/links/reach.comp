#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// For each rule of the ladder the squared centroid distance beyond which chi stays below the rule's threshold.
// chi = tau q2(sigma s) / (2 s^2) with q2(a) <= 15 + 5a + a^2, solved for s; a channel counts up to sigma s = FAINTEST.
layout(constant_id = 0) const uint TABLE1 = 0;
READS(object_params)
READS(leaves)
READS(clusters)
WRITES(reach)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    float tau = clusters[leaves[face]].moment_trace;
    vec4 result = vec4(0);
    for (uint channel = 0; channel < 3; ++channel) {
        float sigma = object_params[0].sigma[channel];
        float real = object_params[0].z_real[channel], virt = object_params[0].z_virtual[channel];
        for (uint rule = 0; rule < 4; ++rule) {
            float k = 2.0 * object_params[0].ladder[rule] / tau - sigma * sigma;
            float s = tau <= 0.0 ? 0.0
                    : k > 0.0 ? (5.0 * sigma + sqrt(25.0 * sigma * sigma + 60.0 * k)) / (2.0 * k) : 1e9;
            if (sigma > 0.0) s = min(s, FAINTEST / sigma);
            float d2 = TABLE1 != 0 ? (s + virt) * (s + virt) : max(0.0, (s - real) * (s + real));
            result[rule] = max(result[rule], d2);
        }
    }
    reach[face] = result;
}
