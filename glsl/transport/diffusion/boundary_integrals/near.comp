#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds near triangles whose layers are kept, each at every receiver of the block.
layout(constant_id = 0) const uint KEPT = 0;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(blocks)
READS(receiver_positions)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
READS(near_layers)
READS(layer_places)
UPDATES(received)
#include "transport/blocks/gather/receiver.glsl"
#include "transport/diffusion/near_receiver.glsl"

uint first, place;

void add(uint i) { sum += layer_places[entries[first + i]].charge * near_layers[kept_place(place, i)]; }

void main() {
    Runs run;
    Receiver self = near_receiver(run, place);
    uint kept = kept_of(run);
    first = run.first + run.expanded + run.direct + run.area + run.edge - kept;
    vec3 all, none;
    sum_near(0, kept, all, none);
    if (stores(self)) received[self.face] += all;
}
