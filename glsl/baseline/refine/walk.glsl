// Decisions: additions, multiplications and comparisons only, all `precise`, so that every device decides alike.
//
// A receiver goes through the emitters that its parent handed down. Each is handed on, split or linked:
// handed on when its solid angle varies too much over the receiver's children (epsilon_1), split when it is too
// large (epsilon_2) or too far from planar. The includer defines what to do with a link and with a hand-down.

#include "dipole/near.glsl"

READS(frame)
READS(topology)
READS(clusters)
READS(reach)
READS(order)
layout(push_constant, scalar) uniform push_block { Range range; };

void on_link(uint receiver, uint emitter, uint rung);
void on_hand(uint emitter);

// 2^40: keeps products of tiny areas and distances away from denormals, which a device may flush.
const float FAR_FROM_DENORMAL = 1099511627776.0;

// Whether |A/d_child^2 - A/d^2| exceeds epsilon_1.
bool deviates(float area, float d2, float child2) {
    precise float change = (area * FAR_FROM_DENORMAL) * abs(d2 - child2);
    precise float allowed = (frame[0].receiver_angle * FAR_FROM_DENORMAL) * (d2 * child2);
    return change > allowed;
}

// Whether A'/A falls short.
bool bent(Cluster emitter) {
    precise vec3 n = emitter.normal * FAR_FROM_DENORMAL;
    precise float area = emitter.area * FAR_FROM_DENORMAL;
    precise float projected = n.x * n.x + n.y * n.y + n.z * n.z;
    precise float needed = frame[0].planarity * (area * area);
    return projected < needed;
}

// 0: one sample serves; 1: area points; 2: the edge form.
uint rung_of(float d2, vec4 radii) {
    if (d2 >= radii.x) return 0;
    return d2 >= min(radii.y, min(radii.z, radii.w)) ? 1 : 2;
}

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
        float d2 = distance2(center, emitter.center);
        bool hands_on = inner && (deviates(emitter.area, d2, distance2(left, emitter.center)) ||
                                  deviates(emitter.area, d2, distance2(right, emitter.center)));
        precise float allowed = frame[0].emitter_angle * d2;
        bool splits = !hands_on && face == NONE && (emitter.area > allowed || bent(emitter));
        if (hands_on) on_hand(node);
        uint rung = face == NONE ? 0 : rung_of(d2, reach[min(face, frame[0].faces - 1)]);
        if (!hands_on && !splits) on_link(receiver, node, rung);
        node = splits ? node + 1 : topology[node].skip;
    }
    return node >= end && next >= lists;
}
