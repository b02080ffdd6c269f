#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds near triangles by 6 area points, each at every receiver of the block; but not those whose layers are kept.
layout(constant_id = 0) const uint KEPT = 0;
layout(push_constant, scalar) uniform push_block { Range range; Range part; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(topology)
READS(triangles)
READS(positions)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
READS(second_moments)
READS(layer_places)
READS(layer_firsts)
READS(layer_squares)
READS(layer_products)
UPDATES(received)
#include "dipole/form_factor/points.glsl"
#include "transport/diffusion/layers.glsl"
#include "transport/blocks/gather/receiver.glsl"
#include "transport/diffusion/near_receiver.glsl"

Receiver self;
uint first;

void add(uint k) {
    uint node = entries[first + k], face = topology[node].face;
    uvec3 corner = triangles[face];
    vec3 a = self.x - positions[corner.x], b = self.x - positions[corner.y], c = self.x - positions[corner.z];
    vec3 charge = layer_places[node].charge;
    LayerFirst u = layer_firsts[node];
    for (uint j = 0; j < 6; ++j) {
        vec4 point = RULE[RULE_FIRST[1] + j];
        vec3 d = point.x * a + point.y * b + point.z * c;
        Kernel kernel = kernel_at(vec3(dot(d, d)));
        vec3 along = (u.x * d.x + u.y * d.y + u.z * d.z) * kernel.by_s;
        sum += point.w * kernel.g * (charge + kernel.c1 * along * kernel.by_s);
    }
}

void main() {
    Runs run;
    self = near_receiver(run);
    first = run.first + run.expanded + run.direct;
    uint last = min(part.first + part.count, computed(run).x);
    vec3 all, none;
    sum_near(part.first, last, all, none);
    if (stores(self) && last > part.first) received[self.face] += all;
}
