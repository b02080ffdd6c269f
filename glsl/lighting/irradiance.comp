#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// E of equation 5 at a face's centroid.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
READS(object_params)
READS(lights)
READS(leaves)
READS(clusters)
READS(lit)
READS(harmonics)
WRITES(irradiance)
#include "lighting/entering.glsl"
#include "geometry/placed.glsl"

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    Cluster leaf = clusters[leaves[face]];
    vec3 normal = leaf.area > 0.0 ? leaf.normal / leaf.area : vec3(0);
    irradiance[face] = entering(0, face, placed(0, leaf.center), turned(0, normal));
}
