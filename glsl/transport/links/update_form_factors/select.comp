#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Selects how many waiting links of each receiver are due, in order, as far as the budget goes, and which receivers are
// summed again: prefix sums by one work group.
layout(push_constant, scalar) uniform push_block { Range range; uint chunk; };
READS(object_params)
READS(order)
READS(stale_counts)
UPDATES(edits)
UPDATES(counters)
UPDATES(active_receivers)
UPDATES(due_groups)
#include "transport/links/groups.glsl"
#define SUM uint
#include "scan.glsl"

// Whether a receiver's links were merged, or some are due.
bool listed(uint receiver) { return edits[receiver].links + edits[receiver].areas + edits[receiver].edges > 0; }

void main() {
    uvec2 run = own_run(range.count);
    uint sum = 0;
    for (uint i = run.x; i < run.y; ++i) sum += stale_counts[order[range.first + i]];
    uint at = sum_before(sum), all = sum_of_all();
    uint spent = chunk == 0 ? 0 : counters[0].computed;
    bool fit = counters[0].overflow == 0 && counters[0].unfinished == 0;
    uint left = fit ? object_params[0].budget - spent : 0, count = 0;
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        uint begin = min(at, left), end = min(at + stale_counts[receiver], left);
        edits[receiver].edge = begin;
        edits[receiver].edges = end - begin;
        at += stale_counts[receiver];
        count += uint(fit && listed(receiver));
    }

    // Every invocation has read the sums and the counters: a barrier alone orders shared memory only.
    memoryBarrierBuffer();
    barrier();
    uint to = range.first + sum_before(count), listed_ = sum_of_all();
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        if (fit && listed(receiver)) active_receivers[to++] = receiver;
    }
    if (gl_LocalInvocationIndex == 0) {
        uint due = min(all, left);
        counters[0].due = due;
        counters[0].computed = spent + due;
        counters[0].stale = (chunk == 0 ? 0 : counters[0].stale) + all - due;
        counters[0].receivers = listed_;
        counters[0].summed = (chunk == 0 ? 0 : counters[0].summed) + listed_;
        due_groups[DUE_SUMMED] = groups(listed_);
    }
}
