// The dipole's profile and its derivatives by half the squared distance: with a = sigma s,
//   p0 = P0 e^-a / s^3,  p1 = p0'/s = -P1 e^-a / s^5,  p2 = p1'/s = P2 e^-a / s^7,
//   P0 = 1 + a,  P1 = 3 + 3a + a^2 = P0 (1 + P0) + 1,  P2 = 15 + 15a + 6a^2 + a^3 = 5 P1 + a^2 P0,
// each summed over both sources, times their depths and the channel's strength. Both sources are two components of a
// vector: each takes an exponential and a square root, and both share a division; depths are bounded so that the
// product of their squared distances stays within f32.
struct Dipole {
    float sigma;
    // Squared depths of the real and the virtual source, and strength times depth.
    vec2 z2, weight;
};

// The includer reads `object_params`. Call it once, outside of loops: loads in loops are expensive.
Dipole dipole_of(uint channel) {
    vec2 z = vec2(object_params[0].z_real[channel], object_params[0].z_virtual[channel]);
    return Dipole(object_params[0].sigma[channel], z * z, object_params[0].strength[channel] * object_params[0].tint[channel] * z);
}

// Of each source: a, 1 / s^2, and e^-a / s^3 times its weight.
struct Sources { vec2 a, inverse, e; };

Sources sources_at(Dipole dipole, float d2) {
    vec2 s2 = d2 + dipole.z2, s = sqrt(s2), inverse = s2.yx * (1.0 / (s2.x * s2.y)), a = dipole.sigma * s;
    return Sources(a, inverse, dipole.weight * exp(-a) * (inverse * s) * inverse);
}

vec3 profile_derivatives(Dipole dipole, float d2) {
    Sources at = sources_at(dipole, d2);
    vec2 p0 = 1.0 + at.a, p1 = p0 * (1.0 + p0) + 1.0, p2 = 5.0 * p1 + at.a * at.a * p0, second = at.e * at.inverse;
    return vec3(dot(at.e, p0), -dot(second, p1), dot(second * at.inverse, p2));
}

// p0 + (p1 tau + p2 along) / 2, the value of one link without its gradient:
//   e^-a / s^3 (P0 (1 + sigma^2 h) + P1 (5 h - tau / 2) / s^2),  h = along / (2 s^2).
float link_value(Dipole dipole, float d2, float half_tau, float half_along) {
    Sources at = sources_at(dipole, d2);
    vec2 p0 = 1.0 + at.a, h = half_along * at.inverse, v = at.inverse * (5.0 * h - half_tau);
    vec2 both = at.e * (p0 * (1.0 + dipole.sigma * dipole.sigma * h + (1.0 + p0) * v) + v);
    return both.x + both.y;
}
