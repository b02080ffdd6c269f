#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A vertex's radiosity: the area-weighted mean of the triangles around it.
READS(object_params)
READS(corner_starts)
READS(corners)
READS(leaves)
READS(clusters)
READS(radiosity)
WRITES(vertex_radiosity)

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    vec3 sum = vec3(0);
    float area = 0.0;
    uint end = corner_starts[vertex + 1];
    for (uint i = corner_starts[vertex]; i < end; ++i) {
        uint face = corners[i];
        float weight = clusters[leaves[face]].area;
        sum += weight * radiosity[face];
        area += weight;
    }
    vertex_radiosity[vertex] = area > 0.0 ? sum / area : vec3(0);
}
