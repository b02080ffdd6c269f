#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Counts the links that each receiver makes and removes, and the emitters that it hands down; one level a dispatch. A
// receiver visits nothing if its parent handed down no emitter that changed or that only one refinement has.
UPDATES(edits)
UPDATES(counters)
READS(handed)
#include "transport/links/update_links/walk.glsl"

uint made_ = 0, undone_ = 0, fresh_ = 0, hands_ = 0;
void on_made(uint emitter, bool fresh) {
    made_++;
    fresh_ += uint(fresh);
}
void on_undone(uint emitter) { undone_++; }
void on_hand(uint emitter, uint who) { hands_++; }

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    uint receiver = order[range.first + i];
    uint parent = topology[receiver].parent;
    uint hand = 0, count = 0;
    if (parent != NONE) {
        hand = edits[parent].hand;
        count = edits[parent].hands;
    }
    if (!walk(receiver, hand, count)) counters[0].unfinished = 1;
    if (made_ > MOST_PAIRS || undone_ > MOST_PAIRS || hands_ > MOST_PAIRS) {
        counters[0].unfinished = 1;
        made_ = undone_ = fresh_ = hands_ = 0;
    }
    edits[receiver] = Span(0, made_, 0, undone_, 0, fresh_, 0, hands_);
}
