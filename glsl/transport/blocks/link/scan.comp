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

#define SUM uvec2
#include "scan.glsl"

shared uint most_near;
const uint BLOCKS_A_GROUP = GROUP_SIZE / BLOCK_RECEIVERS;

// The entries of a block, and whether it has near triangles.
uvec2 places(Runs one) {
    return uvec2(one.expanded + one.direct + one.area + one.edge, min(one.area + one.edge, 1));
}

// Neighbouring invocations take neighbouring blocks, so that their loads share cache lines: first all sums, then the
// place of each block, chunk by chunk.
void main() {
    uint self = gl_LocalInvocationIndex;
    uvec2 sum = uvec2(0);
    uint most = 0;
    if (self == 0) most_near = 0;
    for (uint i = self; i < range.count; i += SCAN_SIZE) {
        Runs one = runs[i];
        sum += places(one);
        most = max(most, one.area + one.edge);
    }
    sum_before(sum);
    atomicMax(most_near, most);
    barrier();
    uvec2 all = sum_of_all();
    bool fits = all.x <= object_params[0].entry_capacity;

    uvec2 begin = uvec2(0);
    for (uint chunk = 0; chunk < range.count; chunk += SCAN_SIZE) {
        uint i = chunk + self;
        Runs one = Runs(0, 0, 0, 0, 0, 0);
        if (i < range.count) one = runs[i];
        uvec2 own = places(one);
        barrier();
        uvec2 at = begin + sum_before(own);
        begin += sum_of_all();
        if (i < range.count) {
            runs[i] = fits ? Runs(at.x, one.expanded, one.direct, one.area, one.edge, one.dropped)
                           : Runs(0, 0, 0, 0, 0, one.dropped);
            if (fits && own.y > 0) near[at.y] = i;
        }
    }
    if (self == 0) {
        // The groups of the kernels for near triangles: with 64 receivers each, and with a block each.
        uint blocks_near = fits ? all.y : 0;
        near_groups[0] = uvec3((blocks_near + BLOCKS_A_GROUP - 1) / BLOCKS_A_GROUP, 1, 1);
        uint row = max(min(blocks_near, GROUPS_A_ROW), 1);
        near_groups[1] = uvec3(min(blocks_near, row), (blocks_near + row - 1) / row, 1);
        near_groups[2] = uvec3(blocks_near, 0, 0);
        counters[0].entries = all.x;
        counters[0].required_entries = max(counters[0].required_entries, all.x);
        counters[0].required_near = max(counters[0].required_near, most_near);
        counters[0].overflow = max(counters[0].overflow, uint(!fits || most_near > object_params[0].near_capacity));
    }
}
