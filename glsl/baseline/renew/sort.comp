#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The due links sorted by rung, each rung in order: a prefix sum by one work group.
READS(frame)
READS(topology)
READS(clusters)
READS(reach)
READS(links)
READS(due)
UPDATES(cursor)
WRITES(ranked)
UPDATES(due_groups)
#include "baseline/groups.glsl"
#include "baseline/refine/decide.glsl"

#define SUM uvec3
#include "scan.glsl"

uint kind_of(uint at) {
    Link link = links[at];
    uint face = topology[link.emitter].face;
    float d2 = distance2(clusters[link.receiver].center, clusters[link.emitter].center);
    return face == NONE ? RUNG_SAMPLE : rung_of(d2, reach[min(face, frame[0].faces - 1)]);
}

void main() {
    uvec2 run = own_run(cursor[0].due);
    uvec3 sum = uvec3(0);
    for (uint i = run.x; i < run.y; ++i) {
        uint kind = kind_of(due[i]);
        sum += uvec3(kind == RUNG_SAMPLE, kind == RUNG_AREA, kind == RUNG_EDGE);
    }
    uvec3 before = sum_before(sum), all = sum_of_all();
    uvec3 at = uvec3(0, all.x, all.x + all.y) + before;
    for (uint i = run.x; i < run.y; ++i) {
        uint kind = kind_of(due[i]);
        ranked[kind == RUNG_SAMPLE ? at.x : kind == RUNG_AREA ? at.y : at.z] = due[i];
        at += uvec3(kind == RUNG_SAMPLE, kind == RUNG_AREA, kind == RUNG_EDGE);
    }
    if (gl_LocalInvocationIndex == 0) {
        cursor[0].due_areas = all.y;
        cursor[0].due_edges = all.z;
        due_groups[RUNG_SAMPLE] = groups(all.x);
        due_groups[RUNG_AREA] = groups(all.y);
        due_groups[RUNG_EDGE] = groups(all.z);
    }
}
