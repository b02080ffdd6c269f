// Fresnel transmittance of a smooth dielectric for unpolarised light from outside, per channel.
vec3 transmittance(vec3 eta, float cosine) {
    if (cosine <= 0.0) return vec3(0);
    float c = min(cosine, 1.0);
    // Only positive terms are added, so that a ray near the critical angle (eta < 1) loses no digits.
    vec3 inner = sqrt(max(vec3(0), c * c - (1.0 - eta) * (1.0 + eta))) / eta;
    vec3 s = c + eta * inner, p = eta * c + inner;
    return min(vec3(1), 2.0 * eta * (c / s * (inner / s) + c / p * (inner / p)));
}

// The cosine to the eye of the facets that let light out of a surface, from that of the surface itself.
float facet_cosine(float cosine, float tilt) {
    return tilt > 0.0 ? sqrt(cosine * cosine * (1.0 - tilt) + tilt) : cosine;
}
