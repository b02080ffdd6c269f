#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A vertex normal: the direction of the summed vector areas of the triangles around it.
READS(object_params)
READS(corner_starts)
READS(corners)
READS(leaves)
READS(clusters)
WRITES(normals)

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    vec3 sum = vec3(0);
    for (uint i = corner_starts[vertex]; i < corner_starts[vertex + 1]; ++i) sum += clusters[leaves[corners[i]]].normal;
    float size = length(sum);
    normals[vertex] = size > 0.0 ? sum / size : vec3(0);
}
