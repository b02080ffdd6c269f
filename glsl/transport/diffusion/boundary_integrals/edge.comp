#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds the nearest triangles by the edge form, each at every receiver of the block; not those whose layers are kept.
layout(constant_id = 0) const uint KEPT = 0;
layout(constant_id = 1) const uint NODES = 6;
layout(push_constant, scalar) uniform push_block { Range range; Range part; };
READS(object_params)
READS(blocks)
READS(receiver_positions)
READS(clusters)
READS(topology)
READS(triangles)
READS(positions)
READS(runs)
READS(entries)
READS(near)
READS(near_groups)
READS(layer_places)
UPDATES(received)
#include "transport/diffusion/edges.glsl"
#include "transport/blocks/gather/receiver.glsl"
#include "transport/diffusion/near_receiver.glsl"

Receiver self;
uint first;

void add(uint i) {
    vec3 k = object_params[0].sigma, z = object_params[0].boundary;
    uint node = entries[first + i], face = topology[node].face;
    Cluster cluster = clusters[node];
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x] - self.x, b = positions[corner.y] - self.x, c = positions[corner.z] - self.x;
    vec3 normal = cluster.area > 0.0 ? cluster.normal / cluster.area : vec3(0);
    vec3 value = layer_places[node].charge / max(cluster.area, 1e-37), single, twice;
    float height = face == self.face ? 0.0 : -dot(cluster.center - self.x, normal);
    layers_of_triangle(k, a, b, c, corner, normal, height, single, twice);
    sum += value * (single + z * twice);
}

void main() {
    Runs run;
    self = near_receiver(run);
    first = run.first + run.expanded + run.direct + run.area;
    uint last = min(part.first + part.count, computed(run).y);
    vec3 all, none;
    sum_near(part.first, last, all, none);
    if (stores(self) && last > part.first) received[self.face] += all;
}
