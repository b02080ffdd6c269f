#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Writes the links that each receiver makes and removes, and what it hands down, where the scan placed them; one level
// a dispatch.
READS(edits)
UPDATES(handed)
WRITES(added_links)
WRITES(removed_links)
#include "transport/links/update_links/walk.glsl"

Span span;
uint at_made = 0, at_undone = 0, at_hand = 0;
void on_made(uint emitter, bool fresh) {
    if (at_made < span.links) added_links[span.link + at_made] = emitter;
    at_made++;
}
void on_undone(uint emitter) {
    if (at_undone < span.areas) removed_links[span.area + at_undone] = emitter;
    at_undone++;
}
void on_hand(uint emitter, uint who) {
    if (at_hand < span.hands) handed[span.hand + at_hand] = emitter * 4 + who;
    at_hand++;
}

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint parent = topology[receiver].parent;
    span = edits[receiver];
    uint hand = 0, count = 0;
    if (parent != NONE) {
        hand = edits[parent].hand;
        count = edits[parent].hands;
    }
    walk(receiver, hand, count);
}
