#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Adds light deposited below near triangles, by the edge form where it is too near for area points. Each invocation
// looks for its own next such triangle: there are few.
layout(constant_id = 0) const uint NODES = 6;
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
#include "transport/diffusion/edges.glsl"
#include "transport/diffusion/source_edges.glsl"
#include "transport/diffusion/source.glsl"
#include "transport/blocks/gather/receiver.glsl"
#define ALONE
#define NO_SUMS
#include "transport/diffusion/near_receiver.glsl"

void main() {
    Runs run;
    Receiver self = near_receiver(run);
    uint first = run.first + run.expanded + run.direct, last = min(part.first + part.count, run.area + run.edge);
    vec3 k = object_params[0].sigma, sum = vec3(0);
    uint at = part.first;
    while (at < last) {
        uint found = NONE;
        while (found == NONE && at < last) {
            uint node = entries[first + at];
            if (too_near(self.x, clusters[node].center, deposits[topology[node].face], emitters[node].area)) found = node;
            ++at;
        }
        if (found != NONE) {
            uint face = topology[found].face;
            Cluster cluster = clusters[found];
            uvec3 corner = triangles[face];
            vec3 a = positions[corner.x] - self.x, b = positions[corner.y] - self.x, c = positions[corner.z] - self.x;
            vec3 normal = cluster.area > 0.0 ? cluster.normal / cluster.area : vec3(0);
            vec3 value = layer_places[found].charge / max(cluster.area, 1e-37);
            Deposit deposit = deposits[face];
            vec3 depth[3] = vec3[3](deposit.red, deposit.green, deposit.blue);
            sum += value * single_at_depths(k, vec3[3](a, b, c), cluster.center - self.x, depth, normal);
        }
    }
    if (self.present && last > part.first) received[self.face] += sum;
}
