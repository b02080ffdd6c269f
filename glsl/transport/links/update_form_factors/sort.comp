#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Sorts the due links by rule, and keeps their order within each rule: a prefix sum by one work group.
READS(object_params)
READS(topology)
READS(clusters)
READS(links)
READS(due_links)
UPDATES(counters)
WRITES(ranked_links)
UPDATES(due_groups)
#include "transport/links/groups.glsl"
#include "transport/links/refine/decide.glsl"
#include "transport/links/refine/rule.glsl"

#define SUM uvec3
#include "scan.glsl"

uint kind_of(uint at) {
    Link link = links[at];
    uint face = topology[link.emitter].face;
    float d2 = distance2(clusters[link.receiver].center, clusters[link.emitter].center);
    return rule_of(d2, link.emitter, face);
}

void main() {
    uvec2 run = own_run(counters[0].due);
    uvec3 sum = uvec3(0);
    for (uint i = run.x; i < run.y; ++i) {
        uint kind = kind_of(due_links[i]);
        sum += uvec3(kind == RULE_SAMPLE, kind == RULE_AREA, kind == RULE_EDGE);
    }
    uvec3 before = sum_before(sum), all = sum_of_all();
    uvec3 at = uvec3(0, all.x, all.x + all.y) + before;
    for (uint i = run.x; i < run.y; ++i) {
        uint kind = kind_of(due_links[i]);
        ranked_links[kind == RULE_SAMPLE ? at.x : kind == RULE_AREA ? at.y : at.z] = due_links[i];
        at += uvec3(kind == RULE_SAMPLE, kind == RULE_AREA, kind == RULE_EDGE);
    }
    if (gl_LocalInvocationIndex == 0) {
        counters[0].due_areas = all.y;
        counters[0].due_edges = all.z;
        due_groups[RULE_SAMPLE] = groups(all.x);
        due_groups[RULE_AREA] = groups(all.y);
        due_groups[RULE_EDGE] = groups(all.z);
    }
}
