#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The due links of each receiver: the first ones that wait.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(cursor)
READS(busy)
READS(spans)
UPDATES(edits)
WRITES(due)
UPDATES(stale)
UPDATES(waiting)

void main() {
    uint place = invocation();
    if (place >= cursor[0].busy) return;
    uint receiver = busy[range.first + place];

    // Its links have been merged.
    edits[receiver].links = 0;
    edits[receiver].areas = 0;
    uint to = edits[receiver].edge, count = edits[receiver].edges;
    if (count == 0) return;
    uint link = spans[receiver].link, last = link + spans[receiver].links, end = to + count;
    while (link < last && to < end) {
        if (stale[link] != 0) {
            stale[link] = 0;
            due[to] = link;
            to++;
        }
        link++;
    }
    waiting[receiver] -= count;
}
