#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"

// Picks the due links of each receiver: the first ones that wait.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(counters)
READS(active_receivers)
READS(spans)
UPDATES(edits)
WRITES(due_links)
UPDATES(stale)
UPDATES(stale_counts)

void main() {
    uint place = invocation();
    if (place >= counters[0].receivers) return;
    uint receiver = active_receivers[range.first + place];

    // Its links have been merged.
    edits[receiver].links = 0;
    edits[receiver].areas = 0;
    uint to = edits[receiver].edge, count = edits[receiver].edges;
    if (count == 0) return;
    uint link = spans[receiver].link, last = link + spans[receiver].links, end = to + count;
    while (link < last && to < end) {
        if (stale[link] != 0) {
            stale[link] = 0;
            due_links[to] = link;
            to++;
        }
        link++;
    }
    stale_counts[receiver] -= count;
}
