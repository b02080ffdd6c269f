// How a photon enters the medium at a triangle: from which light, and the direction inside. SKY is not 0 if there is an
// environment.
#include "transport/walk/entered.glsl"

// The unit direction inside of a photon that enters a triangle, in the object's own frame, as centre and normal are.
// The lights are drawn in proportion to what enters from each; irradiance that none of them explains is the
// environment's, and comes evenly from all directions.
vec3 entry(uint channel, uint face, vec3 center, vec3 normal, uint number, uvec4 random) {
    float eta = object_params[0].eta[channel];
    vec3 place = placed(0, center), out_there = turned(0, normal);
    float direct = 0.0;
    for (uint i = 0; i < object_params[0].lights; ++i) {
        vec3 toward;
        precise float sum = direct + entered(lights[i], channel, face, place, out_there, toward);
        direct = sum;
    }
    precise float sky = SKY != 0 ? max(irradiance[face][channel] - direct, 0.0) : 0.0;
    precise float pick = unit_random(random.w) * (direct + sky);
    float before = 0.0;
    bool found = false;
    vec3 from = normal;
    for (uint i = 0; i < object_params[0].lights; ++i) {
        vec3 toward;
        float one = entered(lights[i], channel, face, place, out_there, toward);
        precise float sum = before + one;
        // Rounding may keep all of them from being found: then the last one counts.
        if (!found && one > 0.0) from = turned_back(toward);
        if (one > 0.0 && pick < sum) found = true;
        before = sum;
    }
    if (SKY != 0) {
        bool open = !found && sky > 0.0;
        uint tries = 0;
        while (open && tries < WALK_TRIES) {
            uvec4 more = random4(number, NONE - tries, channel, walk_params[0].seed);
            float cosine = root_of(unit_random(more.x));
            if (unit_random(more.y) < passes(eta, cosine, inside_of(eta, cosine)) || tries + 1 == WALK_TRIES) {
                from = about(normal, cosine, unit_random(more.z));
                open = false;
            }
            tries++;
        }
    }
    return refracted(eta, from, normal);
}
