#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Moves lists that change behind all others of the chunk, by the farthest end of a list and a prefix sum over the lists
// that move. Lists the receivers that have links to merge. One work group.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(order)
READS(spans)
UPDATES(edits)
UPDATES(counters)
UPDATES(active_receivers)
UPDATES(due_groups)
#include "transport/links/groups.glsl"

#define SUM uvec2
#include "scan.glsl"

shared uint farthest;

// The capacity that a list needs if it changes.
uint room_of(uint receiver) {
    Span edit = edits[receiver];
    return edit.areas + edit.edges > 0 ? spans[receiver].links + edit.links : 0;
}

bool edited(uint receiver) { return edits[receiver].links + edits[receiver].areas > 0; }

void main() {
    uint self = gl_LocalInvocationIndex;
    uvec2 run = own_run(range.count);
    uint end = 0;
    if (self == 0) farthest = 0;
    uvec2 sum = uvec2(0);
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        end = max(end, spans[receiver].link + spans[receiver].links);
        sum += uvec2(room_of(receiver), uint(edited(receiver)));
        uint steps = spans[receiver].links + edits[receiver].links + edits[receiver].areas;
        if (steps > MOST_PAIRS) counters[0].unfinished = 1;
    }
    uvec2 before = sum_before(sum), all = sum_of_all();
    atomicMax(farthest, end);
    barrier();
    uvec2 at = uvec2(farthest, 0) + before;
    uint total = farthest + all.x;
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        uint room = room_of(receiver);
        bool listed = edited(receiver);
        edits[receiver].edge = at.x;
        edits[receiver].edges = room;
        if (listed) active_receivers[range.first + at.y] = receiver;
        at += uvec2(room, uint(listed));
    }
    if (self == 0) {
        counters[0].receivers = all.y;
        counters[0].edited += all.y;
        due_groups[DUE_MERGED] = groups(all.y);
        counters[0].required_links = max(counters[0].required_links, total);
        if (total > object_params[0].link_capacity) counters[0].overflow = 1;
    }
}
