// Uniform point samples in place of the edge form; the paper compares its form factor with them.
READS(object_params)
READS(topology)
READS(clusters)
READS(triangles)
READS(positions)
READS(links)
layout(push_constant, scalar) uniform push_block { float density; };
#include "dipole/profile.glsl"
#include "dipole/distance.glsl"
#include "dipole/form_factor/uniform.glsl"

vec3 uniform_factor(uint at) {
    Link link = links[at];
    Cluster emitter = clusters[link.emitter];
    uint face = topology[link.emitter].face;
    uvec3 corner = triangles[face];
    vec3 receiver = clusters[link.receiver].center;
    vec3 a = positions[corner.x] - receiver, b = positions[corner.y] - receiver, c = positions[corner.z] - receiver;
    vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);

    uint count = sample_count(emitter.area, density);
    vec3 sum = vec3(0);
    for (uint k = 0; k < count; ++k) {
        vec3 place = sample_place(face, k, count);
        vec3 d = -(place.x * a + place.y * b + place.z * c);
        vec3 real = dipole_kernel(object_params[0].sigma, source2(d, normal, object_params[0].z_real, 1.0));
        vec3 virt = dipole_kernel(object_params[0].sigma, source2(d, normal, object_params[0].z_virtual, -1.0));
        sum += object_params[0].z_real * real + object_params[0].z_virtual * virt;
    }
    return emitter.area * object_params[0].strength * (sum / float(count));
}
