// The refinement before and after a change, side by side. A receiver goes through the emitters that its parent handed down
// before, hands down now, or both; only pairs of which a cluster is altered, or whose emitter has another light, or that one of
// the two has alone, are looked at.
READS(frame)
READS(topology)
READS(clusters)
READS(kept_clusters)
READS(altered)
READS(order)
layout(push_constant, scalar) uniform push_block { Range range; };
#include "baseline/refine/decide.glsl"

// Who has a pair: the refinement now, the one before. In `handed` it stands below the emitter, in two bits.
const uint NOW = 1, BEFORE = 2, BOTH = 3;

void on_made(uint emitter, bool fresh);
void on_undone(uint emitter);
void on_hand(uint emitter, uint who);

// False where the driver has cut the loop short.
bool walk(uint receiver, uint hand, uint hands) {
    bool inner = topology[receiver].face == NONE;
    uint l = inner ? receiver + 1 : receiver, r = inner ? topology[receiver + 1].skip : receiver;
    vec3 center = clusters[receiver].center, left = clusters[l].center, right = clusters[r].center;
    vec3 old_center = kept_clusters[receiver].center, old_left = kept_clusters[l].center, old_right = kept_clusters[r].center;
    bool moved = (altered[receiver] & 1) != 0;
    bool root = topology[receiver].parent == NONE;
    uint next = 0, lists = root ? 1 : hands;
    uint node = 0, end = 0, given = BOTH, who = BOTH, until = 0;
    while (node < end || next < lists) {
        if (node >= end) {
            uint item = root ? BOTH : handed[hand + next];
            node = item >> 2;
            given = item & 3;
            end = topology[node].skip;
            until = node;
            next++;
        }
        // Below where the two part, only one of them goes on.
        if (node >= until) who = given;
        bool leaf = topology[node].face != NONE;
        bool idle = who == BOTH && !moved && altered[node] == 0;
        uint now = 0, before = 0;
        if (!idle && (who & NOW) != 0) now = decide(clusters[node], leaf, inner, center, left, right);
        if (!idle && (who & BEFORE) != 0) before = decide(kept_clusters[node], leaf, inner, old_center, old_left, old_right);

        if (now == LINKED) on_made(node, before != LINKED);
        if (before == LINKED && now != LINKED) on_undone(node);
        uint handers = (now == HANDED ? NOW : 0) | (before == HANDED ? BEFORE : 0);
        if (handers != 0) on_hand(node, handers);
        bool down = now == SPLIT || before == SPLIT;
        if (down && who == BOTH && now != before) {
            who = now == SPLIT ? NOW : BEFORE;
            until = topology[node].skip;
        }
        node = down ? node + 1 : topology[node].skip;
    }
    return node >= end && next >= lists;
}
