#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Lists that change go behind all others of the chunk: the farthest end of a list, and a prefix sum over those that move, by one
// group; each invocation owns a run of receivers. Receivers with anything to merge are listed.
layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(frame)
READS(order)
READS(spans)
UPDATES(edits)
UPDATES(cursor)
UPDATES(busy)
UPDATES(due_groups)
#include "baseline/groups.glsl"

shared uint ends[256];
shared uvec2 sums[256];

// What a list that changes may become.
uint room_of(uint receiver) {
    Span edit = edits[receiver];
    return edit.areas + edit.edges > 0 ? spans[receiver].links + edit.links : 0;
}

bool edited(uint receiver) { return edits[receiver].links + edits[receiver].areas > 0; }

void main() {
    uint self = gl_LocalInvocationIndex;
    uint run = (range.count + 255) / 256;
    uint first = min(range.count, self * run), last = min(range.count, first + run);
    uint end = 0;
    uvec2 sum = uvec2(0);
    for (uint i = first; i < last; ++i) {
        uint receiver = order[range.first + i];
        end = max(end, spans[receiver].link + spans[receiver].links);
        sum += uvec2(room_of(receiver), uint(edited(receiver)));
        if (spans[receiver].links + edits[receiver].links + edits[receiver].areas > MOST_PAIRS) cursor[0].unfinished = 1;
    }
    ends[self] = end;
    sums[self] = sum;
    barrier();
    for (uint step = 1; step < 256; step *= 2) {
        uint far = self >= step ? ends[self - step] : 0;
        uvec2 other = self >= step ? sums[self - step] : uvec2(0);
        barrier();
        ends[self] = max(ends[self], far);
        sums[self] += other;
        barrier();
    }
    uvec2 all = sums[255], at = uvec2(ends[255], 0) + sums[self] - sum;
    uint total = ends[255] + all.x;
    for (uint i = first; i < last; ++i) {
        uint receiver = order[range.first + i];
        uint room = room_of(receiver);
        bool listed = edited(receiver);
        edits[receiver].edge = at.x;
        edits[receiver].edges = room;
        if (listed) busy[range.first + at.y] = receiver;
        at += uvec2(room, uint(listed));
    }
    if (self == 0) {
        cursor[0].busy = all.y;
        cursor[0].edited += all.y;
        due_groups[DUE_MERGED] = groups(all.y);
        cursor[0].need_links = max(cursor[0].need_links, total);
        if (total > frame[0].link_room) cursor[0].overflow = 1;
    }
}
