#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The layers of near triangles at each receiver of a block, with charge 1: by 6 area points, or by the edge form.
layout(constant_id = 0) const uint KEPT = 0;
layout(constant_id = 1) const uint NODES = 6;
layout(push_constant, scalar) uniform push_block { Range range; };
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
UPDATES(near_layers)
#include "dipole/form_factor/points.glsl"
#include "transport/diffusion/kernel.glsl"
#include "transport/diffusion/edges.glsl"
#include "transport/blocks/gather/receiver.glsl"
#define NO_SUMS
#include "transport/diffusion/near_receiver.glsl"

void main() {
    Runs run;
    uint slot;
    Receiver self = near_receiver(run, slot);
    uint kept = kept_of(run), first = run.first + run.expanded + run.direct + run.area + run.edge - kept;
    uint sampled = run.area - computed(run).x;
    vec3 k = object_params[0].sigma, z = object_params[0].boundary;
    for (uint i = team(); i < kept; i += TEAMS) {
        uint node = entries[first + i], face = topology[node].face;
        Cluster cluster = clusters[node];
        uvec3 corner = triangles[face];
        vec3 a = positions[corner.x] - self.x, b = positions[corner.y] - self.x, c = positions[corner.z] - self.x;
        vec3 normal = cluster.area > 0.0 ? cluster.normal / cluster.area : vec3(0), sum = vec3(0);
        if (i < sampled) {
            for (uint j = 0; j < 6; ++j) {
                vec4 point = RULE[RULE_FIRST[1] + j];
                vec3 d = point.x * a + point.y * b + point.z * c;
                Kernel kernel = kernel_at(vec3(dot(d, d)));
                sum += point.w * kernel.g * (1.0 - z * kernel.c1 * kernel.by_s * (kernel.by_s * dot(normal, d)));
            }
        } else {
            vec3 single, twice;
            float height = face == self.face ? 0.0 : -dot(cluster.center - self.x, normal);
            layers_of_triangle(k, a, b, c, corner, normal, height, single, twice);
            sum = (single + z * twice) / max(cluster.area, 1e-37);
        }
        if (self.present) near_layers[kept_place(slot, i)] = sum;
    }
}
