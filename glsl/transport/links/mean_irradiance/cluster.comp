#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's irradiance is the area-weighted mean of its children's.
READS(topology)
READS(clusters)
SHARES(cluster_irradiance)
#include "climb.glsl"

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    float whole = clusters[left].area + clusters[right].area;
    float share = whole > 0.0 ? clusters[right].area / whole : 0.5;
    cluster_irradiance[node] = mix(cluster_irradiance[left], cluster_irradiance[right], share);
}
