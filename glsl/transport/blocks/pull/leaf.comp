#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A triangle's moments: the light of channel LEAD at the centroid, or its area if LEAD is NONE, and its second moments.
layout(constant_id = 0) const uint LEAD = 0;
READS(object_params)
READS(leaves)
READS(triangles)
READS(positions)
READS(clusters)
READS(irradiance)
WRITES(moments)
WRITES(second_moments)
#include "transport/blocks/pull/coarse.glsl"

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uint node = leaves[face];
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
    vec3 center = clusters[node].center;
    vec3 p = b - a, q = c - b, r = a - c;
    vec3 diagonal = (p * p + q * q + r * r) / 36.0;
    vec3 mixed = (p.yzx * p.zxy + q.yzx * q.zxy + r.yzx * r.zxy) / 36.0;
    float radius = sqrt(max(dot(a - center, a - center), max(dot(b - center, b - center),
                                                             dot(c - center, c - center))));
    float weight = clusters[node].area * (LEAD == NONE ? 1.0 : irradiance[face][min(LEAD, 2u)]);
    moments[node] = Moment(center, weight);
    second_moments[node] = SecondMoments(diagonal, radius, mixed, coarse_distance(diagonal, radius));
}
