#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The links that are due by what is evaluated, each kind in order, by one group; each invocation owns a run of them.
layout(local_size_x = 256) in;
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

shared uvec3 sums[256];

uint kind_of(uint at) {
    Link link = links[at];
    uint face = topology[link.emitter].face;
    float d2 = distance2(clusters[link.receiver].center, clusters[link.emitter].center);
    return face == NONE ? RUNG_SAMPLE : rung_of(d2, reach[min(face, frame[0].faces - 1)]);
}

void main() {
    uint self = gl_LocalInvocationIndex, total = cursor[0].due;
    uint run = (total + 255) / 256;
    uint first = min(total, self * run), last = min(total, first + run);
    uvec3 sum = uvec3(0);
    for (uint i = first; i < last; ++i) {
        uint kind = kind_of(due[i]);
        sum += uvec3(kind == RUNG_SAMPLE, kind == RUNG_AREA, kind == RUNG_EDGE);
    }
    sums[self] = sum;
    barrier();
    for (uint step = 1; step < 256; step *= 2) {
        uvec3 other = self >= step ? sums[self - step] : uvec3(0);
        barrier();
        sums[self] += other;
        barrier();
    }
    uvec3 all = sums[255];
    uvec3 at = uvec3(0, all.x, all.x + all.y) + sums[self] - sum;
    for (uint i = first; i < last; ++i) {
        uint kind = kind_of(due[i]);
        ranked[kind == RUNG_SAMPLE ? at.x : kind == RUNG_AREA ? at.y : at.z] = due[i];
        at += uvec3(kind == RUNG_SAMPLE, kind == RUNG_AREA, kind == RUNG_EDGE);
    }
    if (self == 0) {
        cursor[0].due_areas = all.y;
        cursor[0].due_edges = all.z;
        due_groups[RUNG_SAMPLE] = groups(all.x);
        due_groups[RUNG_AREA] = groups(all.y);
        due_groups[RUNG_EDGE] = groups(all.z);
    }
}
