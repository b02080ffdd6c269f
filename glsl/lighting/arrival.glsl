// The light that arrives from a light source. SHADOWS is not 0 if there are shadow bits: in `lit`, unless the includer
// defines LIT and LIT_WORDS to read them from another buffer.
#ifndef LIT
#define LIT(word) lit[word]
#define LIT_WORDS object_params[0].shadow_words
#endif

// The share of a light's intensity in the unit direction `away` from it. 1 - cos is computed from the sine, which is
// accurate for narrow cones too.
float emission(Light light, vec3 away) {
    float c = dot(light.axis, away);
    vec3 s = cross(light.axis, away);
    float t = clamp((light.outer - dot(s, s) / (1.0 + max(c, 0.0))) / (light.outer - light.inner), 0.0, 1.0);
    if (light.kind == LIGHT_SPOT) return c > 0.0 ? t * t * (3.0 - 2.0 * t) : 0.0;
    if (light.kind == LIGHT_AREA) return max(c, 0.0);
    return light.kind == LIGHT_AREA_BOTH ? abs(c) : 1.0;
}

// The unit direction towards a light, and the share of its colour that arrives at a point.
float arrival(Light light, vec3 point, out vec3 toward) {
    toward = light.place;
    if (light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY) return 1.0;
    toward -= point;
    float d2 = max(dot(toward, toward), 1e-30);
    toward /= sqrt(d2);
    return emission(light, -toward) / d2;
}

// 1 if a light reaches the face or pixel `index`, whose bits LIT has; 0 if that is in shadow.
float reaches(Light light, uint index) {
    float lets = 1.0;
    if (SHADOWS != 0) {
        if (light.shadow != NONE) {
            uint word = LIT(index * LIT_WORDS + light.shadow / 32);
            lets = float(word >> (light.shadow % 32) & 1u);
        }
    }
    return lets;
}
