#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Whether one light reaches each of some faces: a bit of `lit`. Decisions only.
const uint TEAM_GROUP = GROUP_SIZE;
layout(local_size_x = TEAM_GROUP) in;
layout(constant_id = 0) const uint OTHERS = 0; // not 0 where an object does not shadow itself
layout(constant_id = 1) const uint TEAM = 8; // invocations that walk the wide tree together; 1: each walks the tree
layout(push_constant, scalar) uniform push_block { Rays rays; };
READS(object_params)
READS(lights)
READS(leaves)
READS(clusters)
READS(placed_positions)
READS(triangles)
READS(placed_bounds)
READS(wide_boxes)
UPDATES(lit)
UPDATES(cut_short)
#include "geometry/placed.glsl"
#include "lighting/way.glsl"
#include "lighting/shaft.glsl"

void main() {
    uint lane = gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    // All invocations of a team stay: past the end they have no ray of their own.
    uint k = group * TEAM_GROUP + lane;
    bool there = k < rays.count;
    uint face = rays.first + min(k, rays.count - 1);
    Light light = lights[rays.light];
    vec3 origin = placed(rays.object, clusters[object_params[rays.object].first_node + leaves[face]].center);
    Ask ask = way(light, rays.object, face, origin, there, OTHERS != 0);
    uint met = SHUFFLES != 0 && TEAM > 1 && gl_SubgroupSize >= TEAM ? shaft(ask, lane) : occlusion(ask);
    if (!there) return;
    if (met == UNFINISHED) cut_short[0] = 1;

    // The first light of a word clears it.
    uint word = face * object_params[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint others = bit == 0 ? 0 : lit[word];
    lit[word] = others | (met == FREE ? 1u << bit : 0u);
}
