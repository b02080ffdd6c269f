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
UPDATES(near)
UPDATES(near_groups)

shared uvec2 sums[256];
shared uint most_near;

void main() {
    uint self = gl_LocalInvocationIndex;
    uint each = (range.count + 255) / 256;
    uint first = min(range.count, self * each), last = min(range.count, first + each);
    // Entries, and blocks that have near triangles; the most of these that a block has.
    uvec2 sum = uvec2(0);
    uint most = 0;
    if (self == 0) most_near = 0;
    for (uint i = first; i < last; ++i) {
        Runs one = runs[i];
        sum += uvec2(one.expanded + one.direct + one.area + one.edge, min(one.area + one.edge, 1));
        most = max(most, one.area + one.edge);
    }

    // Inclusive scan of the invocations' sums.
    sums[self] = sum;
    barrier();
    atomicMax(most_near, most);
    for (uint step = 1; step < 256; step *= 2) {
        uvec2 other = self >= step ? sums[self - step] : uvec2(0);
        barrier();
        sums[self] += other;
        barrier();
    }
    uint total = sums[255].x;
    bool fits = total <= frame[0].entry_room;
    uint at = sums[self].x - sum.x, next_near = sums[self].y - sum.y;
    for (uint i = first; i < last; ++i) {
        Runs one = runs[i];
        runs[i] = fits ? Runs(at, one.expanded, one.direct, one.area, one.edge, one.dropped) : Runs(0, 0, 0, 0, 0, one.dropped);
        at += one.expanded + one.direct + one.area + one.edge;
        if (fits && one.area + one.edge > 0) near[next_near++] = i;
    }
    if (self == 0) {
        // 64 receivers a group of the kernels that take near triangles, 16 a block.
        uint blocks_near = fits ? sums[255].y : 0;
        near_groups[0] = uvec3((blocks_near + 3) / 4, 1, 1);
        near_groups[1] = uvec3(blocks_near, 0, 0);
        cursor[0].entries = total;
        cursor[0].need_entries = max(cursor[0].need_entries, total);
        cursor[0].need_near = max(cursor[0].need_near, most_near);
        cursor[0].overflow = max(cursor[0].overflow, uint(!fits || most_near > frame[0].near_room));
    }
}
