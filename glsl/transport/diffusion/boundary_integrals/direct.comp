#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Clusters too near to be expanded, each at every receiver of the block.
layout(local_size_x = GROUP_SIZE) in;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(runs)
READS(entries)
READS(second_moments)
READS(layer_places)
READS(layer_firsts)
READS(layer_squares)
READS(layer_products)
WRITES(received)
#include "transport/diffusion/layers.glsl"
#include "transport/blocks/gather/receiver.glsl"

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    Receiver self = receiver_at(group * gl_WorkGroupSize.x + gl_LocalInvocationIndex);
    Runs run = runs[self.run];
    uint first = run.first + run.expanded, last = first + run.direct;
    vec3 sum = vec3(0);
    for (uint k = first; k < last; ++k) {
        uint node = entries[k];
        Layers m = layers_of(node);
        vec3 x = self.x.x - m.x, y = self.x.y - m.y, z = self.x.z - m.z;
        sum += layers_at(m, second_moments[node], kernel_at(x * x + y * y + z * z), x, y, z);
    }
    if (self.present) received[self.face] = sum;
}
