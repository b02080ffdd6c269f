// The dipole's profile and its derivatives by half the squared distance: with a = sigma s,
//   p0 = (1+a) e^-a / s^3,  p1 = p0'/s = -(3+3a+a^2) e^-a / s^5,  p2 = p1'/s = (15+15a+6a^2+a^3) e^-a / s^7,
// each summed over both sources, times their depths and the channel's strength. Each source takes one exponential;
// square root and division are separate on purpose: neither waits for the other.
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

vec3 source_jet(float sigma, float z2, float weight, float d2) {
    float s2 = d2 + z2, s = sqrt(s2), inverse = 1.0 / s2;
    float a = sigma * s;
    float e = weight * exp(-a) * (inverse * s) * inverse;
    float second = e * inverse;
    return vec3(e + a * e, -(3.0 + a * (3.0 + a)) * second, (15.0 + a * (15.0 + a * (6.0 + a))) * second * inverse);
}

vec3 profile_derivatives(Dipole dipole, float d2) {
    return source_jet(dipole.sigma, dipole.z2.x, dipole.weight.x, d2) +
           source_jet(dipole.sigma, dipole.z2.y, dipole.weight.y, d2);
}

// p0 + (p1 tau + p2 along) / 2: the value of one link, without its gradient.
float source_value(float sigma, float z2, float weight, float d2, float half_tau, float half_along) {
    float s2 = d2 + z2, s = sqrt(s2), inverse = 1.0 / s2;
    float a = sigma * s;
    float e = weight * exp(-a) * (inverse * s) * inverse;
    float first = (3.0 + a * (3.0 + a)) * half_tau;
    float second = (15.0 + a * (15.0 + a * (6.0 + a))) * (half_along * inverse);
    return e * (1.0 + a + inverse * (second - first));
}

float link_value(Dipole dipole, float d2, float half_tau, float half_along) {
    return source_value(dipole.sigma, dipole.z2.x, dipole.weight.x, d2, half_tau, half_along) +
           source_value(dipole.sigma, dipole.z2.y, dipole.weight.y, d2, half_tau, half_along);
}
