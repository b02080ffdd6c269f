#include "layout.glsl"

// One invocation an element; groups are laid out in two dimensions where one would exceed the device's limit.
// The includer defines COUNTED_GROUPS where another kernel counts the groups, of GROUP_SIZE each.
#ifdef COUNTED_GROUPS
layout(local_size_x = GROUP_SIZE) in;
#else
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
#endif

uint invocation() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}
