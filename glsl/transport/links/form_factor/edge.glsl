// The edge form, for the triangles too near for any number of samples.
READS(object_params)
READS(topology)
READS(clusters)
READS(triangles)
READS(positions)
READS(links)
#include "dipole/distance.glsl"
#define NODES 6
#include "dipole/form_factor/edge.glsl"

vec3 edge_factor(uint at) {
    Link link = links[at];
    Cluster emitter = clusters[link.emitter];
    vec3 receiver = clusters[link.receiver].center;
    uvec3 corner = triangles[topology[link.emitter].face];
    vec3 a = positions[corner.x] - receiver, b = positions[corner.y] - receiver, c = positions[corner.z] - receiver;
    vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);
    float height = -dot(emitter.center - receiver, normal);
    vec3 foot = -height * normal;

    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual, sigma = object_params[0].sigma;
    vec3 real = edge_form(sigma, a, b, c, corner, normal, foot, source_height(height, z_real, 1.0));
    vec3 virt = edge_form(sigma, a, b, c, corner, normal, foot, source_height(height, z_virtual, -1.0));
    return object_params[0].strength * (z_real * real + z_virtual * virt);
}
