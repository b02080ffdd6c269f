#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "dipole/near.glsl"
#include "dipole/distance.glsl"
#define NODES 6
#include "dipole/form_factor/edge.glsl"

// Adds at every face of one range, by the edge form, the faces of another range that are too near for one sample.
layout(push_constant, scalar) uniform push_block { Range range; Range emitters; };
READS(object_params)
READS(leaves)
READS(clusters)
READS(triangles)
READS(positions)
READS(reach)
READS(irradiance)
UPDATES(radiosity)

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = range.first + i;
    vec3 center = clusters[leaves[receiver]].center;
    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual, sigma = object_params[0].sigma;
    vec3 sum = vec3(0);
    uint face = emitters.first, end = emitters.first + emitters.count;
    while (face < end) {
        // Looks for the next near face; both variables change only under a condition, which every driver gets right.
        uint found = NONE;
        while (found == NONE && face < end) {
            bool near = distance2(center, clusters[leaves[face]].center) < reach[face].x;
            if (near) found = face;
            if (!near) face++;
        }
        if (found != NONE) {
            Cluster emitter = clusters[leaves[found]];
            uvec3 corner = triangles[found];
            vec3 a = positions[corner.x] - center, b = positions[corner.y] - center, c = positions[corner.z] - center;
            vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);
            float height = -dot(emitter.center - center, normal);
            vec3 foot = -height * normal;
            vec3 real = edge_form(sigma, a, b, c, corner, normal, foot, source_height(height, z_real, 1.0));
            vec3 virt = edge_form(sigma, a, b, c, corner, normal, foot, source_height(height, z_virtual, -1.0));
            sum += irradiance[found] * object_params[0].strength * (z_real * real + z_virtual * virt);
            face = found + 1;
        }
    }
    radiosity[receiver] += sum;
}
