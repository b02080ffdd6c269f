#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// kappa of a vertex from the curvature measures around it: of clusters small compared with the radius, and of the
// corners of triangles that are not.
READS(object_params)
READS(positions)
READS(triangles)
READS(corner_starts)
READS(topology)
READS(bounds)
READS(clusters)
READS(normals)
READS(curvature)
READS(curvature_sums)
WRITES(smooth_kappa)
#include "shading/curvature_sums/part.glsl"

vec3 weighted(vec3 way, float radius, float facing, vec3 part) {
    float near = max(1.0 - dot(way, way) / (radius * radius), 0.0);
    return near * near * max(facing, 0.0) * part;
}

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    uint first = object_params[0].first_vertex, nodes = object_params[0].nodes;
    float radius = object_params[0].curvature_radius;
    vec3 normal = normals[vertex], at = positions[first + vertex], sums = vec3(0);
    // What is summed is a decision.
    precise float reach = radius * radius, small = (SMOOTHING_SHARE * radius) * (SMOOTHING_SHARE * radius);
    bool smooths = radius > 0.0 && normal != vec3(0);
    uint node = smooths ? 0 : nodes, steps = 0;
    while (node < nodes) {
        vec3 low = bounds[node].low, high = bounds[node].high;
        uint skip = topology[node].skip, face = topology[node].face;
        precise vec3 off = max(max(low - at, at - high), vec3(0)), across = high - low;
        precise float far = off.x * off.x + off.y * off.y + off.z * off.z;
        precise float size = across.x * across.x + across.y * across.y + across.z * across.z;
        ++steps;
        bool near = far < reach, large = size > small;
        bool opened = near && large && face == NONE && steps < SMOOTHING_STEPS;
        if (near && large && face != NONE) {
            uvec3 corner = triangles[face], other = corner - first;
            sums += weighted(positions[corner.x] - at, radius, dot(normal, normals[other.x]), part_of(other.x));
            sums += weighted(positions[corner.y] - at, radius, dot(normal, normals[other.y]), part_of(other.y));
            sums += weighted(positions[corner.z] - at, radius, dot(normal, normals[other.z]), part_of(other.z));
        } else if (near && !opened) {
            Cluster cluster = clusters[node];
            CurvatureSum sum = curvature_sums[node];
            float facing = dot(normal, cluster.normal) / max(cluster.area, 1.17549435e-38);
            sums += weighted(cluster.center - at, radius, facing, vec3(sum.area, sum.mean, sum.gaussian));
        }
        node = opened ? node + 1 : skip;
    }
    float kappa = curvature[vertex].kappa;
    if (sums.x > 0.0) {
        float mean = sums.y / sums.x, gaussian = sums.z / sums.x;
        kappa = object_params[0].kappa == KAPPA_RMS ? sqrt(mean * mean + max(mean * mean - gaussian, 0.0)) : abs(mean);
    }
    smooth_kappa[vertex] = kappa;
}
