#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "geometry/area.glsl"

// A leaf's box, centroid, vector area and second moment, from its triangle.
layout(constant_id = 0) const uint RECEIVES = 1;
READS(object_params)
READS(positions)
READS(triangles)
READS(leaves)
READS(topology)
WRITES(bounds)
WRITES(clusters)
UPDATES(receiver_positions)
#include "geometry/refit/way.glsl"

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
    uint node = leaves[face];
    bounds[node] = Bounds(min(min(a, b), c), next_of(topology[node].skip), max(max(a, b), c),
                          object_params[0].first_face + face);

    vec3 e0 = b - a, e1 = c - b, e2 = a - c;
    vec3 normal = vector_area(a, b, c);
    float spread = (dot(e0, e0) + dot(e1, e1) + dot(e2, e2)) / 36.0;
    vec3 center = (a + b + c) / 3.0;
    clusters[node] = Cluster(center, length(normal), normal, spread);
    if (RECEIVES != 0) receiver_positions[face] = center;
}
