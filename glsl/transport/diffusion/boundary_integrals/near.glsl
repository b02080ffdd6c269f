// One invocation a receiver of the blocks that have near triangles; the includer reads what it names.
Receiver near_receiver(out Runs run) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = group * gl_WorkGroupSize.x + gl_LocalInvocationIndex, blocks_near = near_groups[1].x;
    uint run_near = place / BLOCK_RECEIVERS;
    Receiver self = receiver_of(near[min(run_near, blocks_near - 1)], place, run_near < blocks_near);
    run = runs[self.run];
    return self;
}
