#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Counts the entries of each receiver's lists; one level a dispatch.
UPDATES(spans)
UPDATES(counters)
READS(handed)
#include "transport/links/refine/walk.glsl"

uint links = 0, areas = 0, edges = 0, hands = 0;
void on_link(uint receiver, uint emitter, uint rule) {
    links++;
    areas += uint(rule == RULE_AREA);
    edges += uint(rule == RULE_EDGE);
}
void on_hand(uint emitter) { hands++; }

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint parent = topology[receiver].parent;
    uint hand = 0, count = 0;
    if (parent != NONE) {
        hand = spans[parent].hand;
        count = spans[parent].hands;
    }
    if (!walk(receiver, hand, count)) counters[0].unfinished = 1;
    // Too long for any driver's loops, and for 32-bit sums: the frame is void.
    if (links > MOST_PAIRS || hands > MOST_PAIRS) {
        counters[0].unfinished = 1;
        links = areas = edges = hands = 0;
    }
    spans[receiver] = Span(0, links, 0, areas, 0, edges, 0, hands);
}
