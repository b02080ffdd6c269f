// E of equation 5 at a point with a normal: the cosine of every unshadowed light times the Fresnel transmittance, and
// the environment by its harmonics. SHADOWS is not 0 if lights cast shadows, SKY if there is an environment. The lights
// are `lights`, and rays to the environment are even over all directions, unless the includer defines LIGHTS, LIGHT_AT
// and SKY_WEIGHT.
#ifndef LIGHTS
#define LIGHTS object_params[0].lights
#define LIGHT_AT(i) lights[i]
#define SKY_WEIGHT(cosine) (cosine)
#endif
#include "lighting/fresnel.glsl"
#include "lighting/harmonics.glsl"
#include "lighting/arrival.glsl"

// `index` is the face or pixel that the shadow bits belong to.
vec3 entering(uint object, uint index, vec3 point, vec3 normal) {
    bool both = object_params[object].two_sided != 0;
    vec3 sum = vec3(0);

    // Light from the environment in front and behind, and the part of it along unblocked rays.
    vec3 all_front = vec3(0), free_front = vec3(0), all_back = vec3(0), free_back = vec3(0);
    for (uint i = 0; i < LIGHTS; ++i) {
        Light light = LIGHT_AT(i);
        vec3 toward;
        float falloff = arrival(light, point, toward);
        float cosine = dot(normal, toward);
        float counts = both ? abs(cosine) : max(cosine, 0.0);
        float lets = reaches(light, index);
        vec3 passes = transmittance(object_params[object].eta, counts);
        if (light.kind != LIGHT_SKY_RAY) sum += light.color * (falloff * lets) * (counts * passes);
        if (SKY != 0) {
            if (light.kind == LIGHT_SKY_RAY) {
                vec3 weight = sky_radiance(toward) * (SKY_WEIGHT(counts) * passes);
                all_front += cosine > 0.0 ? weight : vec3(0);
                free_front += cosine > 0.0 ? lets * weight : vec3(0);
                all_back += cosine > 0.0 ? vec3(0) : weight;
                free_back += cosine > 0.0 ? vec3(0) : lets * weight;
            }
        }
    }
    if (SKY != 0) {
        // The share is exactly 1 if no ray is blocked.
        bvec3 open_front = equal(free_front, all_front), open_back = equal(free_back, all_back);
        vec3 least = vec3(1e-30);
        sum += sky_irradiance(object, normal) * mix(free_front / max(all_front, least), vec3(1), open_front);
        if (both) sum += sky_irradiance(object, -normal) * mix(free_back / max(all_back, least), vec3(1), open_back);
    }
    return sum;
}
