#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Each receiver's sum: the light it received itself, its block's expansion, and half of its own value. The source term
// is the first vector; with a solution to start from, the operator's product with it is subtracted, and the second
// vector keeps the source term until its norm is known.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = 0) const uint SOURCE = 0;
layout(constant_id = 1) const uint SOLUTION = 0;
layout(push_constant, scalar) uniform push_block { Range range; uint step; };
READS(object_params)
READS(blocks)
READS(spheres)
READS(receiver_positions)
READS(expansions)
READS(received)
READS(solution)
UPDATES(krylov)
#include "transport/blocks/gather/receiver.glsl"

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    Receiver self = receiver_at(group * gl_WorkGroupSize.x + gl_LocalInvocationIndex);
    if (!self.present) return;
    Expansion e = expansions[range.first + self.run];
    vec3 d = self.x - spheres[range.first + self.run].center;
    vec3 value = e.value + d.x * e.x + d.y * e.y + d.z * e.z;
    value += 0.5 * (d.x * d.x * e.xx + d.y * d.y * e.yy + d.z * d.z * e.zz) +
             d.y * d.z * e.yz + d.z * d.x * e.zx + d.x * d.y * e.xy;
    value += received[self.face];
    uint faces = object_params[0].faces;
    if (SOURCE != 0) krylov[self.face] = value;
    else if (SOLUTION != 0) {
        vec3 source = krylov[self.face];
        krylov[faces + self.face] = source;
        krylov[self.face] = source - (value + 0.5 * solution[self.face]);
    }
    else krylov[(step + 1) * faces + self.face] = value + 0.5 * krylov[step * faces + self.face];
}
