#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Saves the positions and clusters for which the links are made now; nothing if the frame has to run again.
READS(object_params)
READS(counters)
READS(positions)
READS(clusters)
WRITES(kept_positions)
WRITES(kept_clusters)

void main() {
    uint i = invocation();
    if (counters[0].overflow != 0 || counters[0].unfinished != 0) return;
    if (i < object_params[0].nodes) kept_clusters[i] = clusters[i];
    uint vertex = object_params[0].first_vertex + i;
    if (i < object_params[0].vertices) kept_positions[vertex] = positions[vertex];
}
