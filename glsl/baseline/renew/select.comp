#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// How many waiting links of each receiver are due, in order, as far as the budget goes, and which receivers are summed
// again: prefix sums by one work group.
layout(push_constant, scalar) uniform push_block { Range range; uint chunk; };
READS(frame)
READS(order)
READS(waiting)
UPDATES(edits)
UPDATES(cursor)
UPDATES(busy)
UPDATES(due_groups)
#include "baseline/groups.glsl"
#define SUM uint
#include "scan.glsl"

// Whether a receiver's links were merged, or some are due.
bool listed(uint receiver) { return edits[receiver].links + edits[receiver].areas + edits[receiver].edges > 0; }

void main() {
    uvec2 run = own_run(range.count);
    uint sum = 0;
    for (uint i = run.x; i < run.y; ++i) sum += waiting[order[range.first + i]];
    uint at = sum_before(sum), all = sum_of_all();
    uint spent = chunk == 0 ? 0 : cursor[0].computed;
    bool fit = cursor[0].overflow == 0 && cursor[0].unfinished == 0;
    uint left = fit ? frame[0].budget - spent : 0, count = 0;
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        uint begin = min(at, left), end = min(at + waiting[receiver], left);
        edits[receiver].edge = begin;
        edits[receiver].edges = end - begin;
        at += waiting[receiver];
        count += uint(fit && listed(receiver));
    }

    // Every invocation has read the sums and the cursor.
    barrier();
    uint to = range.first + sum_before(count), listed_ = sum_of_all();
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        if (fit && listed(receiver)) busy[to++] = receiver;
    }
    if (gl_LocalInvocationIndex == 0) {
        uint due = min(all, left);
        cursor[0].due = due;
        cursor[0].computed = spent + due;
        cursor[0].waiting = (chunk == 0 ? 0 : cursor[0].waiting) + all - due;
        cursor[0].busy = listed_;
        cursor[0].summed = (chunk == 0 ? 0 : cursor[0].summed) + listed_;
        due_groups[DUE_SUMMED] = groups(listed_);
    }
}
