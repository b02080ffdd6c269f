// Near triangles, of which each block keeps the layers of KEPT; the includer reads the buffers named in `near.glsl`.
#ifndef ERRORS
#define ERRORS false
#endif
#include "transport/blocks/gather/near.glsl"

// How many of a block's near triangles have kept layers: the last ones in its list.
uint kept_of(Runs run) { return min(KEPT, run.area + run.edge); }

// How many are computed anew: the first ones, of those that take area points and of those that take the edge form.
uvec2 computed(Runs run) {
    uint anew = run.area + run.edge - kept_of(run);
    return uvec2(min(run.area, anew), anew - min(run.area, anew));
}

// Where a kept triangle's layers at this invocation's receiver are stored.
uint kept_place(uint slot, uint i) {
    return (slot * KEPT + i) * BLOCK_RECEIVERS + gl_LocalInvocationIndex % BLOCK_RECEIVERS;
}
