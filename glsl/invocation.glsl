#include "layout.glsl"

// One invocation an element; groups are laid out in two dimensions where one would exceed the device's limit.
layout(local_size_x = GROUP_SIZE) in;

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}
