#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Only if the error is estimated: the light of the emitters that each block leaves out. All of it has the same sign, so
// it is added before it is squared.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(moments)
READS(second_moments)
UPDATES(expansions)
#include "transport/blocks/link/walk.glsl"
#include "dipole/derivatives.glsl"
#include "transport/blocks/cluster_moments.glsl"
#include "transport/blocks/channels.glsl"
#include "transport/blocks/estimate.glsl"

Dipole dipoles[3];
vec3 sum = vec3(0);
vec3 center;
void on_emitter(uint kind, uint node) {
    if (kind != LINK_DROPPED) return;
    ClusterMoments m = cluster_moments(node);
    vec3 d = center - m.center;
    float d2 = dot(d, d), tau = m.diagonal.x + m.diagonal.y + m.diagonal.z;
    EACH_CHANNEL({ sum[c] += missed_dropped(dipoles[c].sigma, m.weight * profile_derivatives(dipoles[c], d2).x, tau); })
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint block = range.first + i;
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    center = spheres[block].center;
    walk(block, 0);
    expansions[block].error += only_group(sum * sum, vec3(0));
}
