// The distance between source and centroid beyond which chi = tau q2(sigma s) / (2 s^2) stays below a limit in every
// channel, with q2(a) <= 15 + 5a + a^2; a channel counts up to sigma s = FAINTEST. The includer reads `object_params`.
float chi_distance(float trace, float limit) {
    float tau = max(trace, 1e-30);
    vec3 sigma = object_params[0].sigma, k = 2.0 * limit / tau - sigma * sigma;
    vec3 s = (5.0 * sigma + sqrt(25.0 * sigma * sigma + 60.0 * k)) / (2.0 * k);
    s = mix(vec3(FARTHEST), s, greaterThan(k, vec3(0)));
    s = min(mix(s, min(s, FAINTEST / sigma), greaterThan(sigma, vec3(0))), FARTHEST);
    return max(max(s.x, s.y), s.z);
}
