#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's moments from its two children's, by the parallel axis theorem.
layout(constant_id = 0) const uint ORDER = 2;
READS(object_params)
READS(topology)
READS(bounds)
READS(clusters)
SHARES(moments)
SHARES(second_moments)
#include "climb.glsl"
#include "transport/blocks/pull/coarse.glsl"

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    Moment l = moments[left], r = moments[right];
    SecondMoments ls = second_moments[left], rs = second_moments[right];
    Bounds box = bounds[node];
    vec3 area_center = clusters[node].center;
    float weight = l.weight + r.weight;
    // Without light the middle counts.
    float share = weight > 0.0 ? r.weight / weight : 0.5;
    vec3 center = ORDER == 0 ? area_center : l.center + share * (r.center - l.center);
    vec3 to_l = l.center - center, to_r = r.center - center;
    vec3 diagonal = mix(ls.diagonal + to_l * to_l, rs.diagonal + to_r * to_r, share);
    vec3 mixed = mix(ls.mixed + to_l.yzx * to_l.zxy, rs.mixed + to_r.yzx * to_r.zxy, share);
    // Two bounds on the radius: around the children's spheres, and around the box.
    float spheres = max(length(to_l) + ls.radius, length(to_r) + rs.radius);
    vec3 corner = max(center - box.low, box.high - center);
    float radius = min(spheres, length(corner));
    moments[node] = Moment(center, weight);
    second_moments[node] = SecondMoments(diagonal, radius, mixed, coarse_distance(diagonal, radius));
}
