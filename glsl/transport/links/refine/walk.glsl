// A receiver visits the emitters that its parent handed down. Each is handed on, split or linked:
// handed on when its solid angle varies too much over the receiver's children (epsilon_1), split when it is too
// large (epsilon_2) or too far from planar. The includer defines what to do with a link and with a hand-down.

READS(object_params)
READS(topology)
READS(clusters)
READS(order)
layout(push_constant, scalar) uniform push_block { Range range; };
#include "transport/links/refine/decide.glsl"
#include "transport/links/refine/rule.glsl"

void on_link(uint receiver, uint emitter, uint rule);
void on_hand(uint emitter);

// False where the driver has cut the loop short.
bool walk(uint receiver, uint hand, uint hands) {
    vec3 center = clusters[receiver].center;
    bool inner = topology[receiver].face == NONE;
    vec3 left = center, right = center;
    if (inner) {
        left = clusters[receiver + 1].center;
        right = clusters[topology[receiver + 1].skip].center;
    }
    bool root = topology[receiver].parent == NONE;
    uint next = 0, lists = root ? 1 : hands;
    uint node = 0, end = 0;
    while (node < end || next < lists) {
        // Take up the next emitter of the list once the last one's subtree is done.
        if (node >= end) {
            node = root ? 0 : handed[hand + next];
            end = topology[node].skip;
            next++;
        }
        Cluster emitter = clusters[node];
        uint face = topology[node].face;
        uint choice = decide(emitter, face != NONE, inner, center, left, right);
        if (choice == PAIR_HANDED) on_hand(node);
        float d2 = distance2(center, emitter.center);
        uint rule = rule_of(d2, node, face);
        if (choice == PAIR_LINKED) on_link(receiver, node, rule);
        node = choice == PAIR_SPLIT ? node + 1 : topology[node].skip;
    }
    return node >= end && next >= lists;
}
