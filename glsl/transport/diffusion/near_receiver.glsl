// One invocation a receiver of the blocks that have near triangles; the includer reads what it names. `slot` is the
// block's place among them.
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

// How many of a block's near triangles are kept: its last ones.
uint kept_of(Runs run) { return min(KEPT, run.area + run.edge); }

// How many are computed anew, of those that take area points and of those that take the edge form: the first ones.
uvec2 computed(Runs run) {
    uint anew = run.area + run.edge - kept_of(run);
    return uvec2(min(run.area, anew), anew - min(run.area, anew));
}

// Where what a kept triangle gives at this invocation's receiver lies.
uint kept_place(uint slot, uint i) {
    return (slot * KEPT + i) * BLOCK_RECEIVERS + gl_LocalInvocationIndex % BLOCK_RECEIVERS;
}
