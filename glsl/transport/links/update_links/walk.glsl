// The refinements before and after a change, side by side. A receiver visits the emitters that its parent handed down
// in either. A pair is decided only if one of its clusters has moved, if its emitter's light has changed, or if only
// one of the two refinements has it.
READS(object_params)
READS(topology)
READS(clusters)
READS(kept_clusters)
READS(change_flags)
READS(order)
layout(push_constant, scalar) uniform push_block { Range range; };
#include "transport/links/refine/decide.glsl"

void on_made(uint emitter, bool fresh);
void on_undone(uint emitter);
void on_hand(uint emitter, uint who);

// False where the driver has cut the loop short.
bool walk(uint receiver, uint hand, uint hands) {
    bool inner = topology[receiver].face == NONE;
    uint l = inner ? receiver + 1 : receiver, r = inner ? topology[receiver + 1].skip : receiver;
    vec3 center = clusters[receiver].center, left = clusters[l].center, right = clusters[r].center;
    vec3 old_center = kept_clusters[receiver].center;
    vec3 old_left = kept_clusters[l].center, old_right = kept_clusters[r].center;
    bool moved = (change_flags[receiver] & ALTERED_MOVED) != 0;
    bool root = topology[receiver].parent == NONE;
    uint next = 0, lists = root ? 1 : hands;
    uint node = 0, end = 0, given = PAIR_BOTH, who = PAIR_BOTH, until = 0;
    while (node < end || next < lists) {
        if (node >= end) {
            uint item = root ? PAIR_BOTH : handed[hand + next];
            node = item >> 2;
            given = item & PAIR_BOTH;
            end = topology[node].skip;
            until = node;
            next++;
        }
        // Below the node where the two differ, only one of them goes on.
        if (node >= until) who = given;
        bool leaf = topology[node].face != NONE;
        bool idle = who == PAIR_BOTH && !moved && change_flags[node] == 0;
        uint now = 0, before = 0;
        if (!idle && (who & PAIR_NOW) != 0) now = decide(clusters[node], leaf, inner, center, left, right);
        if (!idle && (who & PAIR_BEFORE) != 0) {
            before = decide(kept_clusters[node], leaf, inner, old_center, old_left, old_right);
        }

        if (now == PAIR_LINKED) on_made(node, before != PAIR_LINKED);
        if (before == PAIR_LINKED && now != PAIR_LINKED) on_undone(node);
        uint handers = (now == PAIR_HANDED ? PAIR_NOW : 0) | (before == PAIR_HANDED ? PAIR_BEFORE : 0);
        if (handers != 0) on_hand(node, handers);
        bool down = now == PAIR_SPLIT || before == PAIR_SPLIT;
        if (down && who == PAIR_BOTH && now != before) {
            who = now == PAIR_SPLIT ? PAIR_NOW : PAIR_BEFORE;
            until = topology[node].skip;
        }
        node = down ? node + 1 : topology[node].skip;
    }
    return node >= end && next >= lists;
}
