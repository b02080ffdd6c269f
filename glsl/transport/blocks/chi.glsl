// The distance between source and centroid beyond which chi = tau q2(sigma s) / (2 s^2) stays below a limit in every
// channel, with q2(a) <= 15 + 5a + a^2; a channel counts up to sigma s = FAINTEST. The includer reads `object_params`.
float chi_distance(float trace, float limit) {
    float tau = max(trace, 1e-30), farthest = 0.0;
    for (uint channel = 0; channel < 3; ++channel) {
        float sigma = object_params[0].sigma[channel];
        float k = 2.0 * limit / tau - sigma * sigma;
        float s = k > 0.0 ? (5.0 * sigma + sqrt(25.0 * sigma * sigma + 60.0 * k)) / (2.0 * k) : FARTHEST;
        if (sigma > 0.0) s = min(s, FAINTEST / sigma);
        farthest = max(farthest, min(s, FARTHEST));
    }
    return farthest;
}
