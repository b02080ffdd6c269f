// Decisions: additions, multiplications and comparisons only, all `precise`, so that all devices agree.
//
// A block walks the tree of emitters. Each is dropped, expanded, linked directly or, a triangle too near for that,
// taken by area points or the edge form; otherwise its children are visited.
#include "dipole/near.glsl"

const uint LINK_SHIFT = 28; // lowest bit of a decision's kind; its node is below

READS(object_params)
READS(spheres)
READS(emitters)
READS(expansion_distances)
layout(push_constant, scalar) uniform push_block { Range range; };

// Whether the squared distance is at least (reach + radius)^2; a reach far below 0 is always passed.
bool beyond(float d2, float reach, float radius) {
    precise float sum = max(0.0, reach + radius);
    precise float sum2 = sum * sum;
    return d2 >= sum2;
}

// A block as a walk sees it.
struct Seen { Sphere sphere; uint size_class; bool expandable; };

Seen seen(uint block) {
    Sphere sphere = spheres[block];
    // The class of the block's spread; beyond the last class nothing is expanded.
    uint size_class = uint(sphere.relative_moment > BLOCK_CLASSES[0]) + uint(sphere.relative_moment > BLOCK_CLASSES[1]) +
                      uint(sphere.relative_moment > BLOCK_CLASSES[2]);
    return Seen(sphere, size_class, sphere.relative_moment <= BLOCK_CLASSES[3]);
}

// How the block takes a node.
uint kind_of(Seen block, uint node, Emitter e) {
    float d2 = distance2(block.sphere.center, e.place.xyz), radius = block.sphere.radius;
    bool leaf = e.skip == node + 1;
    uint near = leaf ? (beyond(d2, e.area, radius) ? LINK_AREA : LINK_EDGE) : LINK_OPENED;
    return beyond(d2, e.place.w, radius) ? LINK_DROPPED
         : block.expandable && beyond(d2, expansion_distances[node][block.size_class], radius) ? LINK_EXPANDED
         : beyond(d2, e.accept, radius) ? LINK_DIRECT : near;
}

// Whether nodes of this kind are listed.
bool listed(uint kind) { return kind != LINK_DROPPED && kind != LINK_OPENED; }

void on_emitter(uint kind, uint node);

// One invocation's walk, from this node on. Returns false if the driver has cut the loop short.
bool walk(uint number, uint node) {
    Seen block = seen(number);
    uint end = object_params[0].nodes;
    while (node < end) {
        Emitter e = emitters[node];
        uint kind = kind_of(block, node, e);
        on_emitter(kind, node);
        node = kind == LINK_OPENED ? node + 1 : e.skip;
    }
    return node >= end;
}
