#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether one light reaches each of some faces: a bit of `lit`. Decisions only.
layout(constant_id = 0) const uint OTHERS = 0; // not 0 where an object does not shadow itself
layout(push_constant, scalar) uniform push_block { Rays rays; };
READS(object_params)
READS(lights)
READS(leaves)
READS(clusters)
READS(placed_positions)
READS(triangles)
READS(placed_bounds)
UPDATES(lit)
UPDATES(cut_short)
#include "lighting/way.glsl"
#include "geometry/placed.glsl"

void main() {
    uint k = invocation();
    if (k >= rays.count) return;
    uint face = rays.first + k;
    Light light = lights[rays.light];
    vec3 origin = placed(rays.object, clusters[object_params[rays.object].first_node + leaves[face]].center);
    uint met = way(light, rays.object, face, origin, true, OTHERS != 0);
    if (met == UNFINISHED) cut_short[0] = 1;

    // The first light of a word clears it.
    uint word = face * object_params[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint others = bit == 0 ? 0 : lit[word];
    lit[word] = others | (met == FREE ? 1u << bit : 0u);
}
