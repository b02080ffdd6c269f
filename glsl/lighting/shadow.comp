#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Whether one light reaches each of some faces: a bit of `lit`. Decisions only.
const uint TEAM_GROUP = GROUP_SIZE;
layout(local_size_x = TEAM_GROUP) in;
layout(constant_id = 0) const uint OTHERS = 0; // not 0 where an object does not shadow itself
layout(constant_id = 1) const uint TEAM = 8; // invocations of a team; 1: each ray goes alone
layout(constant_id = 2) const uint SPREAD = 0; // not 0 where a team shares one ray: then it has no shaft, only that ray
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
#include "geometry/shaft.glsl"

// The shaft is the box of the rays' origins, moved to the light; rays that converge there stay within.
vec3 shaft_middle, shaft_size;
Sight shaft_axis;
Nearest shaft_end;

bool in_shaft(vec3 low, vec3 high) {
    return meets(low - shaft_size, high + shaft_size, shaft_middle, shaft_axis, shaft_end);
}

// What a ray meets that the whole team shares: each invocation tests another triangle.
uint spread(Ask ask) {
    Place self = place_in_team();
    shaft_middle = ask.origin;
    shaft_size = vec3(0);
    shaft_axis = sight(ask.direction);
    shaft_end = light_of(shaft_axis, ask.far);
    bool free = ask.wanted;
    Waiting way = Waiting(0, free ? object_params[0].wide_tops : 0, 0);
    while (goes_on(way)) {
        uint count = list_triangles(self, way), hit = 0;
        for (uint at = self.mine; at < count; at += TEAM) {
            uint face = pool[self.list + at];
            uvec3 corner = triangles[face];
            vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
            if (passes(ask, shaft_axis, a, b, c) && blocks(ask, face, a, b, c)) hit = 1;
        }
        if (joined(hit) != 0) {
            free = false;
            way = Waiting(0, 0, 0);
        }
        exchange_in_subgroup();
    }
    return !free ? BLOCKED : waits(way) ? UNFINISHED : FREE;
}

// FREE, BLOCKED, or UNFINISHED for a ray that has to go alone.
uint together(Ask ask) {
    Place self = place_in_team();
    vec3 low = least(ask.wanted ? ask.origin : vec3(NO_BOX)), high = -least(ask.wanted ? -ask.origin : vec3(NO_BOX));
    bool any = low.x <= high.x;
    shaft_middle = any ? 0.5 * (low + high) : vec3(0);
    shaft_size = any ? 0.5 * (high - low) * 1.00001 : vec3(0);
    shaft_axis = sight(ask.far ? ask.light : ask.light - shaft_middle);
    shaft_end = light_of(shaft_axis, ask.far);

    Sight ray = sight(ask.direction);
    bool free = ask.wanted, left = false;
    Waiting way = Waiting(0, any ? object_params[0].wide_tops : 0, 0);
    while (goes_on(way)) {
        uint count = list_triangles(self, way), at = 0;
        for (; at < count; at += TEAM) {
            uint face = pool[self.list + min(at + self.mine, count - 1)];
            uvec3 corner = triangles[face];
            vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
            uint hits = 0;
            for (uint k = 0; k < TEAM; ++k) {
                uint from = self.base + k;
                bool hit = passes(ask, ray, shuffled(a, from), shuffled(b, from), shuffled(c, from));
                hits |= hit ? 1u << k : 0;
            }
            // Few rays pass through a triangle; all invocations stay while any has one to look at.
            hits = free ? hits : 0;
            while (joined(hits) != 0) {
                uint from = self.base + (hits != 0 ? findLSB(hits) : 0);
                uint other = shuffled(face, from);
                bool block = blocks(ask, other, shuffled(a, from), shuffled(b, from), shuffled(c, from));
                free = free && !(hits != 0 && block);
                hits = free ? hits & (hits - 1) : 0;
            }
            left = left || hits != 0;
        }
        left = left || at < count;
        if (joined(uint(free)) == 0) way = Waiting(0, 0, 0);
    }
    return !free ? BLOCKED : left || waits(way) ? UNFINISHED : FREE;
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = group * TEAM_GROUP + lane(), k = SPREAD != 0 ? place / TEAM : place;
    // All invocations of a team stay: past the end they have no ray.
    bool there = k < rays.count;
    uint face = rays.first + min(k, rays.count - 1);
    Light light = lights[rays.light];
    vec3 origin = placed(rays.object, clusters[object_params[rays.object].first_node + leaves[face]].center);
    Ask ask = way(light, rays.object, face, origin, there, OTHERS != 0);
    uint met = !in_teams() ? UNFINISHED : SPREAD != 0 ? spread(ask) : together(ask);
    if (!there || (SPREAD != 0 && place % TEAM != 0)) return;
    if (met == UNFINISHED) met = occlusion(ask);
    if (met == UNFINISHED) cut_short[0] = 1;

    // The first light of a word clears it.
    uint word = face * object_params[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint others = bit == 0 ? 0 : lit[word];
    lit[word] = others | (met == FREE ? 1u << bit : 0u);
}
