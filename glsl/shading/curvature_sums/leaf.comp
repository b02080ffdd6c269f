#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A triangle's share of the curvature measures of its corners.
READS(object_params)
READS(triangles)
READS(corner_starts)
READS(leaves)
READS(curvature)
WRITES(curvature_sums)

// The share of a vertex's measures that each of its triangles takes: area, integral of H, integral of K. Vertices are
// counted from the object's first.
vec3 part_of(uint vertex) {
    Curvature bend = curvature[vertex];
    float share = bend.area / float(corner_starts[vertex + 1] - corner_starts[vertex]);
    return share * vec3(1.0, bend.mean, bend.gaussian);
}

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face] - object_params[0].first_vertex;
    vec3 sum = part_of(corner.x) + part_of(corner.y) + part_of(corner.z);
    curvature_sums[leaves[face]] = CurvatureSum(sum.x, sum.y, sum.z);
}
