#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// B of a receiver: the light that it received itself, from each of its block's lists, and the block's expansion at its
// position. A negative sum is clamped, and counts as error. Channels that are in no group are black.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = 0) const uint ALIVE = 7;
layout(constant_id = 1) const uint ESTIMATE = 0;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(blocks)
READS(spheres)
READS(receiver_positions)
READS(expansions)
READS(received)
READS(area_received)
READS(edge_received)
READS(near_channels)
UPDATES(estimate)
WRITES(radiosity)
#include "transport/blocks/estimate.glsl"
#include "transport/blocks/gather/receiver.glsl"

// The channels of these bits.
bvec3 channels(uint bits) { return bvec3((bits & 1u) != 0, (bits & 2u) != 0, (bits & 4u) != 0); }

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    Receiver self = receiver_at(group * gl_WorkGroupSize.x + gl_LocalInvocationIndex);
    if (!self.present) return;
    vec3 sum = received[self.face];
    uint near = near_channels[range.first + self.run];
    if ((near & 7u) != 0) sum += mix(vec3(0), area_received[self.face], channels(near));
    if (near >> 3 != 0) sum += mix(vec3(0), edge_received[self.face], channels(near >> 3));
    Expansion e = expansions[range.first + self.run];
    vec3 d = self.x - spheres[range.first + self.run].center;
    vec3 value = e.value + d.x * e.x + d.y * e.y + d.z * e.z;
    value += 0.5 * (d.x * d.x * e.xx + d.y * d.y * e.yy + d.z * d.z * e.zz) +
             d.y * d.z * e.yz + d.z * d.x * e.zx + d.x * d.y * e.xy;
    sum += value;
    bvec3 alive = channels(ALIVE);
    radiosity[self.face] = mix(vec3(0), max(sum, vec3(0)), alive);
    if (ESTIMATE != 0) {
        float radius = spheres[range.first + self.run].radius;
        vec3 sigma = object_params[0].sigma, rounding = object_params[0].rounding, own = estimate[self.face];
        vec3 whole = close_estimate(sigma, rounding, own, e.error, e.bend, length(d), radius, sum);
        estimate[self.face] = mix(vec3(0), whole, alive);
    }
}
