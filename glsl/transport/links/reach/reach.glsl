// The squared centroid distance beyond which chi stays below a rule's threshold in every channel.
// chi = tau q2(sigma s) / (2 s^2) with q2(a) <= 15 + 5a + a^2, solved for s; a channel counts up to sigma s = FAINTEST.
layout(constant_id = 0) const uint TABLE1 = 0;
READS(object_params)

float reach2(float tau, uint rule) {
    float farthest = 0.0;
    for (uint channel = 0; channel < 3; ++channel) {
        float sigma = object_params[0].sigma[channel];
        float real = object_params[0].z_real[channel], virt = object_params[0].z_virtual[channel];
        float k = 2.0 * object_params[0].ladder[rule] / tau - sigma * sigma;
        float s = tau <= 0.0 ? 0.0
                : k > 0.0 ? (5.0 * sigma + sqrt(25.0 * sigma * sigma + 60.0 * k)) / (2.0 * k) : 1e9;
        if (sigma > 0.0) s = min(s, FAINTEST / sigma);
        float d2 = TABLE1 != 0 ? (s + virt) * (s + virt) : max(0.0, (s - real) * (s + real));
        farthest = max(farthest, d2);
    }
    return farthest;
}
