// Fresnel transmittance of a smooth dielectric for unpolarised light from outside, per channel.
vec3 transmittance(vec3 eta, float cosine) {
    if (cosine <= 0.0) return vec3(0);
    float c = min(cosine, 1.0);
    vec3 inner = sqrt(max(vec3(0), 1.0 - (1.0 - c * c) / (eta * eta)));
    vec3 s = (c - eta * inner) / (c + eta * inner);
    vec3 p = (eta * c - inner) / (eta * c + inner);
    // At total reflection (eta < 1) s and p are 1, or by the division's rounding a little more.
    return max(vec3(0), 1.0 - 0.5 * (s * s + p * p));
}
