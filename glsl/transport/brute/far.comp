#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "dipole/near.glsl"

// Sums at every face of one range the faces of another range that are far enough for one sample.
layout(push_constant, scalar) uniform push_block { Range range; Range emitters; };
READS(object_params)
READS(topology)
READS(leaves)
READS(clusters)
READS(triangles)
READS(positions)
READS(reach)
READS(irradiance)
UPDATES(radiosity)
#include "dipole/sample.glsl"

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = range.first + i;
    vec3 center = clusters[leaves[receiver]].center;
    vec3 sum = vec3(0);
    for (uint face = emitters.first; face < emitters.first + emitters.count; ++face) {
        uint node = leaves[face];
        Cluster emitter = clusters[node];
        float far = distance2(center, emitter.center) >= reach[face].x ? 1.0 : 0.0;
        sum += far * irradiance[face] * sample_center(node, emitter, face, center - emitter.center);
    }
    radiosity[receiver] = emitters.first == 0 ? sum : radiosity[receiver] + sum;
}
