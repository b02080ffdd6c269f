#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// How many of its waiting links each receiver gets, in the order of the work, as far as the budget goes, and which receivers are
// summed again: prefix sums by one group; each invocation owns a run of receivers.
layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { Range range; uint chunk; };
READS(frame)
READS(order)
READS(waiting)
UPDATES(edits)
UPDATES(cursor)
UPDATES(busy)
UPDATES(due_groups)
#include "baseline/groups.glsl"

shared uint sums[256];

// The sum over the invocations up to this one.
uint scan(uint self, uint sum) {
    sums[self] = sum;
    barrier();
    for (uint step = 1; step < 256; step *= 2) {
        uint other = self >= step ? sums[self - step] : 0;
        barrier();
        sums[self] += other;
        barrier();
    }
    return sums[self];
}

// Whether a receiver's links were merged, or some are due.
bool listed(uint receiver) { return edits[receiver].links + edits[receiver].areas + edits[receiver].edges > 0; }

void main() {
    uint self = gl_LocalInvocationIndex;
    uint run = (range.count + 255) / 256;
    uint first = min(range.count, self * run), last = min(range.count, first + run);
    uint sum = 0;
    for (uint i = first; i < last; ++i) sum += waiting[order[range.first + i]];
    uint at = scan(self, sum) - sum, all = sums[255];
    uint spent = chunk == 0 ? 0 : cursor[0].computed;
    bool fit = cursor[0].overflow == 0 && cursor[0].unfinished == 0;
    uint left = fit ? frame[0].budget - spent : 0, count = 0;
    for (uint i = first; i < last; ++i) {
        uint receiver = order[range.first + i];
        uint begin = min(at, left), end = min(at + waiting[receiver], left);
        edits[receiver].edge = begin;
        edits[receiver].edges = end - begin;
        at += waiting[receiver];
        count += uint(fit && listed(receiver));
    }

    // Every invocation has read the sums and the cursor.
    barrier();
    uint to = range.first + scan(self, count) - count, listed_ = sums[255];
    for (uint i = first; i < last; ++i) {
        uint receiver = order[range.first + i];
        if (fit && listed(receiver)) busy[to++] = receiver;
    }
    if (self == 0) {
        uint due = min(all, left);
        cursor[0].due = due;
        cursor[0].computed = spent + due;
        cursor[0].waiting = (chunk == 0 ? 0 : cursor[0].waiting) + all - due;
        cursor[0].busy = listed_;
        cursor[0].summed = (chunk == 0 ? 0 : cursor[0].summed) + listed_;
        due_groups[DUE_SUMMED] = groups(listed_);
    }
}
