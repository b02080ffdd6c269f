#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// kappa of a vertex from the curvature measures around it: those of clusters that are small compared with the radius,
// and of triangles of any size.
READS(object_params)
READS(positions)
READS(vertex_order)
READS(bounds)
READS(clusters)
READS(normals)
READS(curvature)
READS(curvature_sums)
WRITES(smooth_kappa)

void main() {
    uint place = invocation();
    if (place >= object_params[0].vertices) return;
    // In this order neighbouring invocations visit the same nodes.
    uint vertex = vertex_order[place];
    uint nodes = object_params[0].nodes, start = object_params[0].first_node;
    float radius = object_params[0].curvature_radius;
    vec3 normal = normals[vertex], at = positions[object_params[0].first_vertex + vertex], sums = vec3(0);
    // Which nodes are summed is a decision.
    precise float reach = radius * radius, small = (SMOOTHING_SHARE * radius) * (SMOOTHING_SHARE * radius);
    bool smooths = radius > 0.0 && normal != vec3(0);
    float over = smooths ? 1.0 / reach : 0.0;
    uint node = smooths ? 0 : nodes, steps = 0;
    while (node < nodes) {
        Bounds box = bounds[node];
        precise vec3 off = max(max(box.low - at, at - box.high), vec3(0)), across = box.high - box.low;
        precise float far = off.x * off.x + off.y * off.y + off.z * off.z;
        precise float size = across.x * across.x + across.y * across.y + across.z * across.z;
        ++steps;
        bool counts = far < reach, opened = counts && size > small && box.face == NONE && steps < SMOOTHING_STEPS;
        if (counts && !opened) {
            Cluster cluster = clusters[node];
            CurvatureSum sum = curvature_sums[node];
            vec3 way = cluster.center - at;
            float near = max(1.0 - dot(way, way) * over, 0.0);
            float facing = max(dot(normal, cluster.normal), 0.0) / max(cluster.area, 1.17549435e-38);
            sums += near * near * facing * vec3(sum.area, sum.mean, sum.gaussian);
        }
        node = opened ? node + 1 : box.next - start;
    }
    float kappa = curvature[vertex].kappa;
    if (sums.x > 0.0) {
        float mean = sums.y / sums.x, gaussian = sums.z / sums.x;
        kappa = object_params[0].kappa == KAPPA_RMS ? sqrt(mean * mean + max(mean * mean - gaussian, 0.0)) : abs(mean);
    }
    smooth_kappa[vertex] = kappa;
}
