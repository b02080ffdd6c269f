#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// E of equation 5 at a face's centroid: every light's cosine times Fresnel transmittance, where it is not shadowed, and
// the environment by its harmonics.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
READS(frame)
READS(lights)
READS(leaves)
READS(clusters)
READS(lit)
READS(harmonics)
WRITES(irradiance)
#include "light/entering.glsl"

void main() {
    uint face = invocation();
    if (face >= frame[0].faces) return;
    Cluster leaf = clusters[leaves[face]];
    vec3 normal = leaf.area > 0.0 ? leaf.normal / leaf.area : vec3(0);
    irradiance[face] = entering(0, face, leaf.center, normal);
}
