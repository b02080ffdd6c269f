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
#include "shading/curvature_sums/part.glsl"

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face] - object_params[0].first_vertex;
    vec3 sum = part_of(corner.x) + part_of(corner.y) + part_of(corner.z);
    curvature_sums[leaves[face]] = CurvatureSum(sum.x, sum.y, sum.z);
}
