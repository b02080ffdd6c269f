#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Where each block's lists begin: a prefix sum over the batch, by one group; each invocation owns a run of blocks.
// If they don't fit they are emptied and the overflow noted: the frame is then run again with more room.
layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(frame)
UPDATES(runs)
UPDATES(cursor)

shared uint sums[256];

void main() {
    uint self = gl_LocalInvocationIndex;
    uint each = (range.count + 255) / 256;
    uint first = min(range.count, self * each), last = min(range.count, first + each);
    uint sum = 0;
    for (uint i = first; i < last; ++i) sum += runs[i].expanded + runs[i].direct + runs[i].area + runs[i].edge;

    // Inclusive scan of the invocations' sums.
    sums[self] = sum;
    barrier();
    for (uint step = 1; step < 256; step *= 2) {
        uint other = self >= step ? sums[self - step] : 0;
        barrier();
        sums[self] += other;
        barrier();
    }
    uint total = sums[255];
    bool fits = total <= frame[0].entry_room;
    uint at = sums[self] - sum;
    for (uint i = first; i < last; ++i) {
        Runs one = runs[i];
        runs[i] = fits ? Runs(at, one.expanded, one.direct, one.area, one.edge, one.dropped) : Runs(0, 0, 0, 0, 0, one.dropped);
        at += one.expanded + one.direct + one.area + one.edge;
    }
    if (self == 0) {
        cursor[0].entries = total;
        cursor[0].need_entries = max(cursor[0].need_entries, total);
        cursor[0].overflow = max(cursor[0].overflow, uint(!fits));
    }
}
