// 3, 6 or 12 samples on the emitting triangle, by the first rule of the ladder that the distance allows.
READS(object_params)
READS(topology)
READS(clusters)
READS(triangles)
READS(positions)
READS(reach)
READS(links)
#include "dipole/profile.glsl"
#include "dipole/distance.glsl"
#include "dipole/form_factor/points.glsl"
#include "dipole/near.glsl"

vec3 area_factor(uint at) {
    Link link = links[at];
    Cluster emitter = clusters[link.emitter];
    vec3 receiver = clusters[link.receiver].center;
    uint face = topology[link.emitter].face;
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
    vec3 normal = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);

    float d2 = distance2(receiver, emitter.center);
    vec4 radii = reach[face];
    uint rule = d2 >= radii.y ? 0 : d2 >= radii.z ? 1 : 2;
    vec3 sum = vec3(0);
    for (uint k = 0; k < RULE_COUNT[rule]; ++k) {
        vec4 point = RULE[RULE_FIRST[rule] + k];
        vec3 d = receiver - (point.x * a + point.y * b + point.z * c);
        vec3 real = dipole_kernel(object_params[0].sigma, source2(d, normal, object_params[0].z_real, 1.0));
        vec3 virt = dipole_kernel(object_params[0].sigma, source2(d, normal, object_params[0].z_virtual, -1.0));
        sum += point.w * (object_params[0].z_real * real + object_params[0].z_virtual * virt);
    }
    return emitter.area * object_params[0].strength * sum;
}
