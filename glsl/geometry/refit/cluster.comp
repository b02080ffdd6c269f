#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's box, centroid, vector area and second moment, from its two children.
READS(object_params)
READS(topology)
SHARES(bounds)
SHARES(clusters)
#include "climb.glsl"
#include "geometry/refit/way.glsl"

// `part` / `whole`, or one half if `whole` is 0: triangles may vanish in single precision.
float share(float part, float whole) { return whole > 0.0 ? part / whole : 0.5; }

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    vec3 low = min(bounds[left].low, bounds[right].low), high = max(bounds[left].high, bounds[right].high);
    bounds[node] = Bounds(low, next_of(topology[node].skip), high, NONE);

    Cluster l = clusters[left], r = clusters[right];
    float area = l.area + r.area;
    vec3 center = l.center + share(r.area, area) * (r.center - l.center);
    vec3 to_l = l.center - center, to_r = r.center - center;
    float moment = l.area * (l.moment_trace + dot(to_l, to_l)) + r.area * (r.moment_trace + dot(to_r, to_r));
    clusters[node] = Cluster(center, area, l.normal + r.normal, area > 0.0 ? moment / area : 0.0);
}
