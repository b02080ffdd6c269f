#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Only if the error is estimated: the light of the emitters that each block leaves out, all of one sign.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(moments)
READS(spreads)
UPDATES(expansions)
#include "transport/link/walk.glsl"
#include "dipole/jet.glsl"
#include "transport/cloud.glsl"
#include "transport/channels.glsl"
#include "transport/estimate.glsl"

Dipole dipoles[3];
vec3 sum = vec3(0);
vec3 center;
void on_emitter(uint kind, uint node) {
    if (kind != LINK_DROPPED) return;
    Cloud m = cloud_of(node);
    vec3 d = center - m.center;
    float d2 = dot(d, d), tau = m.diagonal.x + m.diagonal.y + m.diagonal.z;
    EACH_CHANNEL({ sum[c] += missed_dropped(dipoles[c].sigma, m.weight * jet(dipoles[c], d2).x, tau); })
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint block = range.first + i;
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    center = spheres[block].center;
    walk(block);
    expansions[block].error += only_group(sum * sum, vec3(0));
}
