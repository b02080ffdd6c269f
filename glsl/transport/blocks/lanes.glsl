// Groups whose invocations share an item; with LANES = 1 each invocation has an item of its own.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = LANES_ID) const uint LANES = 1; // invocations that share an item: 1, or all those of the group

// The item of this invocation.
uint item() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return LANES == 1 ? group * gl_WorkGroupSize.x + gl_LocalInvocationIndex : group;
}
