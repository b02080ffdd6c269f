// Decisions on a pair: additions, multiplications and comparisons only, all `precise`, so that all devices agree.
// The includer reads `object_params`.
#include "dipole/near.glsl"

// Whether |A/d_child^2 - A/d^2| exceeds epsilon_1.
bool deviates(float area, float d2, float child2) {
    precise float change = (area * FAR_FROM_DENORMAL) * abs(d2 - child2);
    precise float allowed = (object_params[0].receiver_angle * FAR_FROM_DENORMAL) * (d2 * child2);
    return change > allowed;
}

// Whether A'/A is too small.
bool bent(Cluster emitter) {
    precise vec3 n = emitter.normal * FAR_FROM_DENORMAL;
    precise float area = emitter.area * FAR_FROM_DENORMAL;
    precise float projected = n.x * n.x + n.y * n.y + n.z * n.z;
    precise float needed = object_params[0].planarity * (area * area);
    return projected < needed;
}

// `left` and `right` are the centres of the receiver's children, if it is an inner node.
uint decide(Cluster emitter, bool leaf, bool inner, vec3 center, vec3 left, vec3 right) {
    float d2 = distance2(center, emitter.center);
    bool hands_on = inner && (deviates(emitter.area, d2, distance2(left, emitter.center)) ||
                              deviates(emitter.area, d2, distance2(right, emitter.center)));
    precise float allowed = object_params[0].emitter_angle * d2;
    bool splits = !leaf && (emitter.area > allowed || bent(emitter));
    return hands_on ? PAIR_HANDED : splits ? PAIR_SPLIT : PAIR_LINKED;
}
