#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The moments of a cluster's vertices from its two children's.
READS(topology)
SHARES(vertex_moments)
#include "climb.glsl"
#include "layers/vertex_moments.glsl"

void of_cluster(uint node, uint right) {
    vertex_moments[node] = joined(vertex_moments[node + 1], vertex_moments[right]);
}
