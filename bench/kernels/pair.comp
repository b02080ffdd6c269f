#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint NODES = 6;
#include "dipole/form_factor/edge.glsl"
#include "dipole/profile.glsl"
#include "geometry/area.glsl"

// Form factors of one triangle per invocation at several receivers, three channels, radial distances: by one sample
// with its second moment (0 nodes) or by the edge form. The first receiver is the origin; the others are offset along
// an edge.
struct Pair {
    vec3 a, b, c;
    vec3 sigma, z_real, z_virtual, strength;
};
layout(set = 0, binding = 0, scalar) restrict readonly buffer pairs_block { uint count; uint receivers; Pair pairs[]; };
layout(set = 0, binding = 1, scalar) restrict writeonly buffer sums_block { vec3 sums[]; };

vec3 by_sample(Pair pair, float area) {
    vec3 center = (pair.a + pair.b + pair.c) / 3.0, e0 = pair.b - pair.a, e1 = pair.c - pair.b, e2 = pair.a - pair.c;
    float tau = (dot(e0, e0) + dot(e1, e1) + dot(e2, e2)) / 36.0, d2 = dot(center, center);
    vec3 dots = vec3(dot(e0, center), dot(e1, center), dot(e2, center));
    float along = dot(dots, dots) / 36.0;
    vec3 real2 = d2 + pair.z_real * pair.z_real, virtual2 = d2 + pair.z_virtual * pair.z_virtual;
    vec3 real = dipole_kernel(pair.sigma, real2) * moment_correction(pair.sigma, real2, tau, along);
    vec3 virt = dipole_kernel(pair.sigma, virtual2) * moment_correction(pair.sigma, virtual2, tau, along);
    return area * (pair.z_real * real + pair.z_virtual * virt);
}

vec3 by_edges(Pair pair, vec3 normal) {
    float height = -dot((pair.a + pair.b + pair.c) / 3.0, normal);
    vec3 foot = -height * normal;
    vec3 h_real = sqrt(height * height + pair.z_real * pair.z_real);
    vec3 h_virtual = sqrt(height * height + pair.z_virtual * pair.z_virtual);
    uvec3 id = uvec3(0, 1, 2);
    return pair.z_real * edge_form(pair.sigma, pair.a, pair.b, pair.c, id, normal, foot, h_real)
         + pair.z_virtual * edge_form(pair.sigma, pair.a, pair.b, pair.c, id, normal, foot, h_virtual);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    Pair pair = pairs[i];
    vec3 area = vector_area(pair.a, pair.b, pair.c), normal = normalize(area), step = 0.01 * (pair.b - pair.a);
    vec3 sum = vec3(0);
    for (uint k = 0; k < receivers; ++k) {
        if (NODES == 0) sum += by_sample(pair, length(area));
        if (NODES != 0) sum += by_edges(pair, normal);
        pair.a += step;
        pair.b += step;
        pair.c += step;
    }
    sums[i] = pair.strength * sum;
}
