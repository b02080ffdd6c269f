// The light that enters a triangle: area times irradiance, as a number and as an integer.
#include "transport/walk/entry_sums/factors.glsl"

vec3 entering_light(uint face) {
    precise vec3 light = clusters[leaves[face]].area * irradiance[face];
    return mix(vec3(0), light, greaterThan(light, vec3(1e-30)));
}

uvec3 whole_light(uint face, uvec3 factor) {
    precise vec3 light = entering_light(face) * uintBitsToFloat(factor);
    return uvec3(light);
}

uint entry_block_count() { return (object_params[0].faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK; }
