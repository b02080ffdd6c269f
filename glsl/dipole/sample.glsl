// One sample of a triangle or cluster at its centre: the form factor of a plain link, and of a pair of brute force.
// The includer reads object_params, triangles and positions.
#include "dipole/profile.glsl"
#include "dipole/distance.glsl"

// Form factor of an emitter for a receiver at `d` from its centre.
vec3 sample_center(uint node, Cluster emitter, uint face, vec3 d) {
    vec3 mean = emitter.area > 0.0 ? emitter.normal / emitter.area : vec3(0);
    vec3 z_real = object_params[0].z_real, z_virtual = object_params[0].z_virtual, sigma = object_params[0].sigma;

    // A cluster's sources are displaced along its mean normal, not normalised; a triangle's along its own normal.
    vec3 real2, virtual2;
    if (TABLE1 != 0 && face == NONE) {
        for (uint c = 0; c < 3; ++c) {
            vec3 to_real = d + z_real[c] * mean, to_virtual = d - z_virtual[c] * mean;
            real2[c] = max(dot(to_real, to_real), z_real[c] * z_real[c]);
            virtual2[c] = max(dot(to_virtual, to_virtual), z_virtual[c] * z_virtual[c]);
        }
    } else {
        real2 = source2(d, mean, z_real, 1.0);
        virtual2 = source2(d, mean, z_virtual, -1.0);
    }

    // A triangle's second moment is known exactly; a cluster is a point, as published.
    float tau = 0.0, along = 0.0;
    if (face != NONE) {
        uvec3 corner = triangles[face];
        vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
        vec3 dots = vec3(dot(b - a, d), dot(c - b, d), dot(a - c, d));
        tau = emitter.moment_trace;
        along = dot(dots, dots) / 36.0;
    }
    vec3 real = dipole_kernel(sigma, real2) * moment_correction(sigma, real2, tau, along);
    vec3 virt = dipole_kernel(sigma, virtual2) * moment_correction(sigma, virtual2, tau, along);
    return emitter.area * object_params[0].strength * (z_real * real + z_virtual * virt);
}
