// Decisions: additions, multiplications and comparisons only, all `precise`, so that all devices agree.
//
// A block walks the tree of emitters. Each is dropped, expanded, linked directly or, a triangle too near for that,
// taken by area points or the edge form; otherwise its children are visited.
#include "dipole/near.glsl"

READS(object_params)
READS(spheres)
READS(emitters)
READS(expansion_distances)
layout(push_constant, scalar) uniform push_block { Range range; };

void on_emitter(uint kind, uint node);

// Whether the squared distance is at least (reach + radius)^2; a reach far below 0 is always passed.
bool beyond(float d2, float reach, float radius) {
    precise float sum = max(0.0, reach + radius);
    precise float sum2 = sum * sum;
    return d2 >= sum2;
}

// From this node on. False where the driver has cut the loop short.
bool walk(uint block, uint node) {
    Sphere sphere = spheres[block];
    // A class for the block's spread; beyond the last nothing is expanded.
    uint size_class = uint(sphere.relative_moment > BLOCK_CLASSES[0]) + uint(sphere.relative_moment > BLOCK_CLASSES[1]) +
                        uint(sphere.relative_moment > BLOCK_CLASSES[2]);
    bool expandable = sphere.relative_moment <= BLOCK_CLASSES[3];
    uint end = object_params[0].nodes;
    while (node < end) {
        Emitter e = emitters[node];
        float d2 = distance2(sphere.center, e.place.xyz);
        bool leaf = e.skip == node + 1;
        uint near = leaf ? (beyond(d2, e.area, sphere.radius) ? LINK_AREA : LINK_EDGE) : LINK_OPENED;
        uint kind = beyond(d2, e.place.w, sphere.radius) ? LINK_DROPPED
                  : expandable && beyond(d2, expansion_distances[node][size_class], sphere.radius) ? LINK_EXPANDED
                  : beyond(d2, e.accept, sphere.radius) ? LINK_DIRECT : near;
        on_emitter(kind, node);
        node = kind == LINK_OPENED ? node + 1 : e.skip;
    }
    return node >= end;
}
