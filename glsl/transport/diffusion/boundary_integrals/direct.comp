#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// Sums clusters too near to be expanded, each at every receiver of the block.
layout(constant_id = 0) const uint SOURCE = 0;
const uint ESTIMATE = 0;
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
#include "transport/blocks/direct.glsl"

void add_some(vec3 receiver, uint first, uint at, uint count, uint width) {
    uint mine = SUBGROUP_LANE % width, base = SUBGROUP_LANE - mine;
    vec3 none = vec3(0);
    uint node = entries[first + min(at + mine, count - 1)];
    Layers load = layers_of(node);
    SecondMoments area = second_moments[node];
    uint last = min(width, count - at);
    for (uint k = 0; k < last; ++k) {
        uint from = base + k;
        // The source term has the middle of its charge at its own place in each channel. About it there is no first
        // moment, and so no product of that with the area's moments.
        bool source = SOURCE != 0;
        vec3 place = shuffled(vec3(load.x.x, load.y.x, load.z.x), from);
        vec3 px = source ? shuffled(load.x, from) : vec3(place.x), py = source ? shuffled(load.y, from) : vec3(place.y);
        vec3 pz = source ? shuffled(load.z, from) : vec3(place.z);
        Layers m = Layers(px, py, pz, shuffled(load.w, from), source ? none : shuffled(load.ux, from),
                          source ? none : shuffled(load.uy, from), source ? none : shuffled(load.uz, from),
                          shuffled(load.xx, from), shuffled(load.yy, from), shuffled(load.zz, from),
                          shuffled(load.yz, from), shuffled(load.zx, from), shuffled(load.xy, from));
        SecondMoments second = area;
        second.diagonal = source ? none : shuffled(area.diagonal, from);
        second.mixed = source ? none : shuffled(area.mixed, from);
        vec3 x = receiver.x - m.x, y = receiver.y - m.y, z = receiver.z - m.z;
        sum += layers_at(m, second, kernel_at(x * x + y * y + z * z), x, y, z);
    }
}

void main() {
    Receiver self;
    vec3 all, no_errors;
    if (sum_of_runs(self, all, no_errors)) received[self.face] = all;
}
