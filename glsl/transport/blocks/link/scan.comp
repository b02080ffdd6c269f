#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Where each block's lists begin: a prefix sum over the batch by one work group. If they do not fit they are emptied
// and the overflow noted: the frame then runs again with more capacity.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
UPDATES(runs)
UPDATES(counters)
UPDATES(near)
UPDATES(near_groups)

#define SUM uvec4
#include "scan.glsl"

const uint BLOCKS_A_GROUP = GROUP_SIZE / BLOCK_RECEIVERS;

// The near triangles of a block; of the last one beyond the batch. These loads, and those below, wait for nothing.
uint near_triangles(uint i) {
    uint block = min(i, range.count - 1);
    return runs[block].area + runs[block].edge;
}

// The entries of a block, and whether it has near triangles; nothing beyond the batch.
uvec2 places(uint i) {
    uint block = min(i, range.count - 1), triangles = near_triangles(i);
    return uvec2(runs[block].expanded + runs[block].direct + triangles, min(triangles, 1)) * uint(i < range.count);
}

void put(uint i, uvec2 at, uint is_near) {
    if (i >= range.count) return;
    runs[i].first = at.x;
    if (is_near > 0) near[at.y] = i;
}

// Neighbouring invocations take neighbouring blocks, so that their loads share cache lines; two each at once.
void main() {
    uint self = gl_LocalInvocationIndex, most = 0;
    uvec2 all = uvec2(0);
    for (uint chunk = 0; chunk < range.count; chunk += 2 * SCAN_SIZE) {
        uint one = chunk + self, two = one + SCAN_SIZE;
        uvec4 own = uvec4(places(one), places(two));
        most = max(most, max(near_triangles(one), near_triangles(two)));
        barrier();
        uvec4 before = sum_before(own), sum = sum_of_all();
        put(one, all + before.xy, own.y);
        put(two, all + sum.xy + before.zw, own.w);
        all += sum.xy + sum.zw;
    }
    // The most near triangles of a block take the place of a sum, which all have read.
    barrier();
    if (self == 0) sums[0].x = 0;
    barrier();
    atomicMax(sums[0].x, most);
    memoryBarrierBuffer(); // a barrier alone orders shared memory only
    barrier();
    uint most_near = sums[0].x;
    bool fits = all.x <= object_params[0].entry_capacity;
    for (uint i = self; !fits && i < range.count; i += SCAN_SIZE) runs[i] = Runs(0, 0, 0, 0, 0, runs[i].dropped);
    if (self == 0) {
        // The groups of the kernels for near triangles: with 64 receivers each, and with a block each.
        uint blocks_near = fits ? all.y : 0;
        near_groups[0] = uvec3((blocks_near + BLOCKS_A_GROUP - 1) / BLOCKS_A_GROUP, 1, 1);
        uint row = max(min(blocks_near, GROUPS_A_ROW), 1);
        near_groups[1] = uvec3(min(blocks_near, row), (blocks_near + row - 1) / row, 1);
        near_groups[2] = uvec3(blocks_near, 0, 0);
        counters[0].entries = all.x;
        counters[0].noted = 0;
        counters[0].required_entries = max(counters[0].required_entries, all.x);
        counters[0].required_near = max(counters[0].required_near, most_near);
        counters[0].overflow = max(counters[0].overflow, uint(!fits || most_near > object_params[0].near_capacity));
    }
}
