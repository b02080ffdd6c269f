#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// No photon is under way yet.
READS(walk_params)
WRITES(photons)
WRITES(balances)

void main() {
    uint slot = invocation();
    if (slot >= walk_params[0].slots) return;
    uvec2 none = uvec2(0);
    photons[slot] = Photon(vec3(0), vec3(0), 0, 0, 0, 0, 0, 0);
    balances[slot] = WalkBalance(none, none, none, none, none, none);
}
