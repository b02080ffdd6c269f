#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's curvature measures from its two children's.
READS(topology)
SHARES(curvature_sums)
#include "climb.glsl"

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    CurvatureSum l = curvature_sums[left], r = curvature_sums[right];
    curvature_sums[node] = CurvatureSum(l.area + r.area, l.mean + r.mean, l.gaussian + r.gaussian);
}
