// The distance beyond which the coarse solution takes a cluster as one: chi at its nearest point stays below
// COARSE_CHI.
#include "transport/blocks/chi.glsl"

float coarse_distance(vec3 diagonal, float radius) {
    return radius + chi_distance(diagonal.x + diagonal.y + diagonal.z, COARSE_CHI);
}
