// The lobes of reflection: GGX and Phong.

vec3 unit(vec3 v) {
    return v / sqrt(max(dot(v, v), 1e-30));
}

// Microfacets (Walter et al. 2007): G / (4 (n.v) (n.l)), masking and shadowing together as in Heitz 2014, equation 99.
float masking(float alpha, float seen, float lights) {
    float a2 = alpha * alpha;
    float sum = lights * sqrt(seen * seen * (1.0 - a2) + a2) + seen * sqrt(lights * lights * (1.0 - a2) + a2);
    return 0.5 / max(sum, 1e-30);
}

// D of the facet between two directions.
float facet_density(float alpha, vec3 normal, vec3 facet) {
    vec3 aside = cross(normal, facet);
    float along = dot(normal, facet), spread = alpha * alpha * along * along + dot(aside, aside);
    return alpha * alpha / (3.14159265358979 * spread * spread);
}

// GGX without Fresnel's factor in a direction, and the density of rays there by facets as the eye sees them.
vec2 facet_lobe(float alpha, vec3 normal, float seen, vec3 eye, vec3 direction) {
    float facets = facet_density(alpha, normal, unit(eye + direction));
    float slope = sqrt(seen * seen * (1.0 - alpha * alpha) + alpha * alpha);
    return facets * vec2(masking(alpha, seen, max(dot(normal, direction), 0.0)), 0.5 / (seen + slope));
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

// Phong's lobe without Fresnel's factor in a direction, and the density of rays there by the facets that stand for it.
vec2 phong_lobe(float exponent, vec3 mirror, vec3 direction) {
    float cosine = max(dot(mirror, direction), 0.0), alpha = sqrt(4.0 / (exponent + 3.0));
    float lobe = (exponent + 2.0) / (2.0 * 3.14159265358979) * power(cosine, uint(exponent));
    return vec2(lobe, facet_density(alpha, mirror, direction) * cosine);
}
