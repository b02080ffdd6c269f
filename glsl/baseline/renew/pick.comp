#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The links of each receiver that are due: the first ones that wait.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(order)
READS(spans)
READS(edits)
WRITES(due)
UPDATES(stale)
UPDATES(waiting)

void main() {
    uint place = invocation();
    if (place >= range.count) return;
    uint receiver = order[range.first + place];
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
