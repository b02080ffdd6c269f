// One invocation an element; groups are laid out in two dimensions where one would exceed the device's limit.
layout(local_size_x = 64) in;

const uint NONE = 0xffffffffu;

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}
