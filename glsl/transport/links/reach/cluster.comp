#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "transport/links/reach/reach.glsl"

// A cluster's reach for one sample; 0 where it has no border to integrate over.
READS(clusters)
READS(borders)
WRITES(cluster_reach)

void main() {
    uint node = invocation();
    if (node >= object_params[0].nodes) return;
    cluster_reach[node] = borders[node].y > 0 ? reach2(clusters[node].moment_trace, 0) : 0.0;
}
