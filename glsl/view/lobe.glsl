// The lobes of reflection: GGX and Phong.

// Microfacets (Walter et al. 2007): G / (4 (n.v) (n.l)), masking and shadowing together as in Heitz 2014, equation 99.
float masking(float alpha, float seen, float lights) {
    float a2 = alpha * alpha;
    float sum = lights * sqrt(seen * seen * (1.0 - a2) + a2) + seen * sqrt(lights * lights * (1.0 - a2) + a2);
    return 0.5 / max(sum, 1e-30);
}

// GGX with its cosine, without Fresnel's factor, divided by the density of facets as the eye sees them: G2 / G1.
float facet_weight(float alpha, float seen, float cosine) {
    float a2 = alpha * alpha, slope = sqrt(seen * seen * (1.0 - a2) + a2);
    float sum = cosine * slope + seen * sqrt(cosine * cosine * (1.0 - a2) + a2);
    return cosine * (seen + slope) / max(sum, 1e-30);
}

// A cosine to the power of a whole number up to 1023.
float power(float cosine, uint exponent) {
    float value = 1.0, base = max(cosine, 0.0);
    for (uint bit = 0; bit < 10; ++bit) {
        value *= (exponent >> bit & 1u) != 0 ? base : 1.0;
        base *= base;
    }
    return value;
}

// Phong's lobe about `mirror` in a direction, divided by the density D(c) c of the facets that stand for it.
float phong_weight(float exponent, vec3 mirror, vec3 direction) {
    float cosine = max(dot(mirror, direction), 0.0), a2 = 4.0 / (exponent + 3.0);
    vec3 aside = cross(mirror, direction);
    float spread = a2 * cosine * cosine + dot(aside, aside);
    return (0.5 * exponent + 1.0) * power(cosine, uint(exponent) - 1) * spread * spread / a2;
}
