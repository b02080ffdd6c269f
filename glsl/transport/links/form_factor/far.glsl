// One sample at the emitter's centre.
READS(object_params)
READS(topology)
READS(clusters)
READS(triangles)
READS(positions)
READS(links)
#include "dipole/sample.glsl"

vec3 far_factor(uint at) {
    Link link = links[at];
    Cluster emitter = clusters[link.emitter];
    vec3 d = clusters[link.receiver].center - emitter.center;
    return sample_center(link.emitter, emitter, topology[link.emitter].face, d);
}
