// How much light enters the medium at a triangle from each light. SHADOWS is not 0 if lights cast shadows.

// The share of a light's intensity in the unit direction `away` from it.
float emitted(Light light, vec3 away) {
    float c = dot3(light.axis, away);
    vec3 s = cross3(light.axis, away);
    float beyond = dot3(s, s) * inverse_of(1.0 + max(c, 0.0));
    precise float width = light.outer - light.inner;
    precise float t = clamp((light.outer - beyond) * inverse_of(max(width, 1e-20)), 0.0, 1.0);
    precise float smooth_step = t * t * (3.0 - 2.0 * t);
    if (light.kind == LIGHT_SPOT) return c > 0.0 ? smooth_step : 0.0;
    if (light.kind == LIGHT_AREA) return max(c, 0.0);
    return light.kind == LIGHT_AREA_BOTH ? abs(c) : 1.0;
}

// Light of one channel that enters at a triangle's centre from a light, and the unit direction towards that light; all
// in the scene's frame.
float entered(Light light, uint channel, uint face, vec3 center, vec3 normal, out vec3 toward) {
    bool far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
    precise vec3 apart = light.place - center;
    float d2 = max(dot3(apart, apart), 1e-30);
    vec3 unit = unit_of(apart);
    toward = far ? light.place : unit;
    float falls = emitted(light, -unit) * inverse_of(d2);
    float cosine = max(dot3(normal, toward), 0.0);
    float eta = object_params[0].eta[channel];
    float share = passes(eta, cosine, inside_of(eta, cosine));
    precise float sum = light.color[channel] * (far ? 1.0 : falls) * (cosine * share);
    bool lit_there = true;
    if (SHADOWS != 0) {
        if (light.shadow != NONE) {
            uint word = lit[face * object_params[0].shadow_words + light.shadow / 32];
            lit_there = (word >> (light.shadow % 32) & 1u) != 0u;
        }
    }
    return lit_there && light.kind != LIGHT_SKY_RAY ? sum : 0.0;
}

// A direction in the scene, turned into the object's own frame.
vec3 turned_back(vec3 v) {
    ObjectParams own = object_params[0];
    precise vec3 sum = v.x * own.turn_x + v.y * own.turn_y + v.z * own.turn_z;
    return sum;
}
