// Squares of what the transport may miss at a receiver, but for `missed_dropped`, which the caller squares; the CPU
// reference gives the reasons. `p` is the profile with its derivatives, times the cluster's weight; `tau` is the trace
// of the cluster's second moments.

float squared(float x) { return x * x; }

// chi for tau = 1.
float unit_chi(vec3 p, float d2, float z2) { return 0.5 * p.z * (d2 + z2) / max(p.x, 1e-37); }

// How the profile grows from a cluster's centroid to its near side.
float nearer(float sigma, float tau) { return exp(min(sigma * sqrt(tau), ESTIMATE_STEEPEST)); }

float missed_moments(uint order, float sigma, vec3 p, float unit, float tau) {
    float chi = unit * tau;
    float share = order == 2 ? 0.15 * chi * sqrt(chi) : order == 1 ? chi : sqrt(chi);
    return squared(p.x * min(share, 1.0) * nearer(sigma, tau));
}

// The expansion's error at the block's radius.
float missed_bend(vec3 p, float unit, float radius) {
    float chi = unit * radius * radius;
    return squared(p.x * 0.4 * chi * sqrt(chi) / (1.0 + 0.4 * chi));
}

float missed_points(vec3 p, float unit, float tau) {
    float chi = unit * tau;
    return squared(p.x * min(0.006 * chi * chi * chi, 1.0));
}

float missed_dropped(float sigma, float value, float tau) {
    float t = min(sigma * sqrt(3.0 * tau), ESTIMATE_STEEPEST);
    return value * (t > 1e-2 ? 0.5 * (exp(t) - exp(-t)) / t : 1.0);
}

// Not squared.
vec3 missed_edge(uint nodes, vec3 sigma, float tau, vec3 value) {
    vec3 size = min(sigma * sqrt(tau), vec3(3));
    return value * size * (nodes == 3 ? vec3(5e-3) : (nodes == 6 ? 4e-4 : 1e-6) * size);
}

// The estimate of a receiver.
vec3 close_estimate(vec3 sigma, vec3 rounding, vec3 own, vec3 center, vec3 rim, float offset, float radius, vec3 sum) {
    float out2 = radius > 0.0 ? squared(offset / radius) : 0.0;
    vec3 block = ESTIMATE_BOTH * exp(min(2.0 * sigma * offset, vec3(ESTIMATE_STEEPEST))) *
                 (center + rim * (out2 * out2 * out2));
    return ESTIMATE_SAFETY * sqrt(own + block) + rounding * abs(sum) + max(-sum, vec3(0));
}
