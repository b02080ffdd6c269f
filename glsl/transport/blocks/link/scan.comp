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

void main() {
    uint self = gl_LocalInvocationIndex;
    uvec2 run = own_run(range.count);
    // The entries, the blocks that have near triangles, and the most near triangles of a block.
    uvec2 sum = uvec2(0);
    uint most = 0;
    if (self == 0) most_near = 0;
    for (uint i = run.x; i < run.y; ++i) {
        Runs one = runs[i];
        sum += uvec2(one.expanded + one.direct + one.area + one.edge, min(one.area + one.edge, 1));
        most = max(most, one.area + one.edge);
    }

    uvec2 before = sum_before(sum);
    atomicMax(most_near, most);
    barrier();
    uint total = sum_of_all().x;
    bool fits = total <= object_params[0].entry_capacity;
    uint at = before.x, next_near = before.y;
    for (uint i = run.x; i < run.y; ++i) {
        Runs one = runs[i];
        runs[i] = fits ? Runs(at, one.expanded, one.direct, one.area, one.edge, one.dropped)
                       : Runs(0, 0, 0, 0, 0, one.dropped);
        at += one.expanded + one.direct + one.area + one.edge;
        if (fits && one.area + one.edge > 0) near[next_near++] = i;
    }
    if (self == 0) {
        // The groups of the kernels for near triangles: with 64 receivers each, and with a block each.
        uint blocks_near = fits ? sum_of_all().y : 0;
        near_groups[0] = uvec3((blocks_near + BLOCKS_A_GROUP - 1) / BLOCKS_A_GROUP, 1, 1);
        uint row = max(min(blocks_near, GROUPS_A_ROW), 1);
        near_groups[1] = uvec3(min(blocks_near, row), (blocks_near + row - 1) / row, 1);
        near_groups[2] = uvec3(blocks_near, 0, 0);
        counters[0].entries = total;
        counters[0].required_entries = max(counters[0].required_entries, total);
        counters[0].required_near = max(counters[0].required_near, most_near);
        counters[0].overflow = max(counters[0].overflow, uint(!fits || most_near > object_params[0].near_capacity));
    }
}
