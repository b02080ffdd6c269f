#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// One sample at the emitter's centre for every link; the nearer ones are computed again after.
READS(frame)
READS(cursor)
READS(topology)
READS(clusters)
READS(triangles)
READS(positions)
READS(links)
WRITES(factors)
#include "dipole/sample.glsl"

void main() {
    uint i = invocation();
    if (i >= cursor[0].links || cursor[0].overflow != 0) return;
    Link link = links[i];
    Cluster emitter = clusters[link.emitter];
    vec3 d = clusters[link.receiver].center - emitter.center;
    factors[i] = sample_center(link.emitter, emitter, topology[link.emitter].face, d);
}
