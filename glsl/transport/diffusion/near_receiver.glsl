// One invocation for each receiver of the blocks that have near triangles; the includer reads the buffers named here.
// `slot` is the block's place among them.
Receiver near_receiver(out Runs run, out uint slot) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = group * gl_WorkGroupSize.x + gl_LocalInvocationIndex, blocks_near = near_groups[1].x;
    uint run_near = place / BLOCK_RECEIVERS;
    slot = min(run_near, blocks_near - 1);
    Receiver self = receiver_of(near[slot], place, run_near < blocks_near);
    run = runs[self.run];
    return self;
}

Receiver near_receiver(out Runs run) {
    uint slot;
    return near_receiver(run, slot);
}

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
