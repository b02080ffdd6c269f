// E of equation 5 at a point of an object with a normal: the cosine of every unshadowed light times the Fresnel
// transmittance, and the environment by its harmonics. SHADOWS is not 0 if lights cast any, SKY if there is an
// environment.
#include "lighting/fresnel.glsl"
#include "lighting/harmonics.glsl"
#include "lighting/arrival.glsl"

// `index` is that of the face, or of the pixel, that the bits of shadow belong to.
vec3 entering(uint object, uint index, vec3 point, vec3 normal) {
    bool both = object_params[object].two_sided != 0;
    vec3 sum = vec3(0);

    // Light from the environment in front and behind, and the part of it along unblocked rays.
    vec3 all_front = vec3(0), free_front = vec3(0), all_back = vec3(0), free_back = vec3(0);
    for (uint i = 0; i < object_params[0].lights; ++i) {
        Light light = lights[i];
        vec3 toward;
        float falloff = arrival(light, point, toward);
        float cosine = dot(normal, toward);
        float counts = both ? abs(cosine) : max(cosine, 0.0);
        float lets = reaches(light, index);
        vec3 enters = counts * transmittance(object_params[object].eta, counts);
        if (light.kind != LIGHT_SKY_RAY) sum += light.color * (falloff * lets) * enters;
        if (SKY != 0) {
            if (light.kind == LIGHT_SKY_RAY) {
                vec3 weight = sky_radiance(toward) * enters;
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
