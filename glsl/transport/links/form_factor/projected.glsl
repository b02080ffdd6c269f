// The polygon that a near cluster's triangles make on the plane across its mean normal; it is smaller than the cluster,
// but sends out the cluster's light.
READS(object_params)
READS(topology)
READS(clusters)
READS(positions)
READS(borders)
READS(border_edges)
READS(links)
#include "dipole/distance.glsl"
#define NODES 3
#include "dipole/form_factor/edge.glsl"
#include "dipole/form_factor/polygon.glsl"

vec3 projected_factor(uint at) {
    Link link = links[at];
    Cluster emitter = clusters[link.emitter];
    vec3 receiver = clusters[link.receiver].center;
    float size = length(emitter.normal);
    vec3 normal = size > 0.0 ? emitter.normal / size : vec3(0);
    float height = dot(receiver - emitter.center, normal);
    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual;
    vec3 real = source_height(height, z_real, 1.0), virt = source_height(height, z_virtual, -1.0);
    uvec2 border = borders[link.emitter];
    float share = size > 0.0 ? emitter.area / size : 0.0;
    return share * object_params[0].strength * polygon_form(border.x, border.y, receiver, normal,
                                                            object_params[0].sigma, real, virt, z_real, z_virtual);
}
