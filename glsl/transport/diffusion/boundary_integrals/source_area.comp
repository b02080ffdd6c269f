#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds light deposited below near triangles, by 6 area points where it is far enough for them, at every receiver of the
// block.
// Layers of the light are not kept: its place may change with every frame.
const uint KEPT = 0;
layout(push_constant, scalar) uniform push_block { Range range; Range part; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(clusters)
READS(topology)
READS(triangles)
READS(positions)
READS(deposits)
READS(emitters)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
READS(layer_places)
UPDATES(received)
#include "dipole/form_factor/points.glsl"
#include "transport/diffusion/kernel.glsl"
#include "transport/diffusion/source.glsl"
#include "transport/blocks/gather/receiver.glsl"
#include "transport/diffusion/near_receiver.glsl"

Receiver self;
uint first;

void add(uint k) {
    uint node = entries[first + k], face = topology[node].face;
    uvec3 corner = triangles[face];
    Deposit deposit = deposits[face];
    vec3 a = self.x - positions[corner.x], b = self.x - positions[corner.y], c = self.x - positions[corner.z];
    vec3 dx = vec3(deposit.red.x, deposit.green.x, deposit.blue.x), one = vec3(0);
    vec3 dy = vec3(deposit.red.y, deposit.green.y, deposit.blue.y);
    vec3 dz = vec3(deposit.red.z, deposit.green.z, deposit.blue.z);
    for (uint j = 0; j < 6; ++j) {
        vec4 point = RULE[RULE_FIRST[1] + j];
        vec3 d = point.x * a + point.y * b + point.z * c, x = d.x - dx, y = d.y - dy, z = d.z - dz;
        one += point.w * kernel_at(x * x + y * y + z * z).g;
    }
    bool near_by = too_near(self.x, clusters[node].center, deposit, emitters[node].area);
    sum += near_by ? vec3(0) : layer_places[node].charge * one;
}

void main() {
    Runs run;
    self = near_receiver(run);
    first = run.first + run.expanded + run.direct;
    uint last = min(part.first + part.count, run.area + run.edge);
    vec3 all, none;
    sum_near(part.first, last, all, none);
    if (stores(self) && last > part.first) received[self.face] += all;
}
