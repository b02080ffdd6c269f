#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Writes each receiver's lists where the scan placed them; one level a dispatch.
READS(spans)
UPDATES(handed)
WRITES(links)
WRITES(area_links)
WRITES(edge_links)
#include "transport/links/refine/walk.glsl"

Span span;
uint at_link = 0, at_area = 0, at_edge = 0, at_hand = 0;
void on_link(uint receiver, uint emitter, uint rule) {
    if (at_link < span.links) links[span.link + at_link] = Link(receiver, emitter);
    if (rule == RULE_AREA) {
        if (at_area < span.areas) area_links[span.area + at_area] = span.link + at_link;
        at_area++;
    }
    if (rule == RULE_EDGE) {
        if (at_edge < span.edges) edge_links[span.edge + at_edge] = span.link + at_link;
        at_edge++;
    }
    at_link++;
}
void on_hand(uint emitter) {
    if (at_hand < span.hands) handed[span.hand + at_hand] = emitter;
    at_hand++;
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint parent = topology[receiver].parent;
    span = spans[receiver];
    uint hand = 0, count = 0;
    if (parent != NONE) {
        hand = spans[parent].hand;
        count = spans[parent].hands;
    }
    walk(receiver, hand, count);
}
