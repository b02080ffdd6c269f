#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A vertex normal: the direction of the summed vector areas of the triangles around it, or where they cancel, as
// between two sides of a sheet, that of the first triangle with an area. Where triangles were divided, it is known.
layout(constant_id = 0) const uint KNOWN = 0;
READS(object_params)
READS(corner_starts)
READS(corners)
READS(leaves)
READS(clusters)
READS(whole_normals)
WRITES(normals)

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    if (KNOWN == 1) {
        normals[vertex] = whole_normals[vertex];
        return;
    }
    vec3 sum = vec3(0), own = vec3(0);
    float area = 0;
    for (uint i = corner_starts[vertex]; i < corner_starts[vertex + 1]; ++i) {
        uint leaf = leaves[corners[i]];
        if (area == 0) own = clusters[leaf].normal;
        sum += clusters[leaf].normal;
        area += clusters[leaf].area;
    }
    // Of a sum that vanishes only rounding is left.
    if (length(sum) <= 1e-5 * area) sum = own;
    float size = length(sum);
    normals[vertex] = size > 0.0 ? sum / size : vec3(0);
}
