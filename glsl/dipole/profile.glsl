// The dipole's kernel p(s) = (1 + sigma s) e^{-sigma s} / s^3 (Table 1), per channel, and its correction by moments.
// Square root and division are separate on purpose: both are cheap, and neither waits for the other.
vec3 dipole_kernel(vec3 sigma, vec3 s2) {
    vec3 s = sqrt(s2);
    vec3 a = sigma * s;
    return (1.0 + a) * exp(-a) / (s2 * s);
}

// 1 + (p1 tau + p2 d.M.d) / (2 p): the second-order correction of one sample for a second moment M of trace tau.
vec3 moment_correction(vec3 sigma, vec3 s2, float tau, float along) {
    vec3 a = sigma * sqrt(s2);
    vec3 first = (3.0 + 3.0 * a + a * a) * tau;
    vec3 second = (15.0 + 15.0 * a + a * a * (6.0 + a)) * along / s2;
    return 1.0 + 0.5 * (second - first) / ((1.0 + a) * s2);
}
