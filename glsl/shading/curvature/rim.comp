#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Curvature of vertices not surrounded by triangles: the mean over the corners of their triangles that have their own.
READS(object_params)
READS(triangles)
READS(corner_starts)
READS(corners)
UPDATES(curvature)
#include "shading/curvature/ring.glsl"

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    if (curvature[vertex].area > 0.0) return;
    uint first = object_params[0].first_vertex;
    vec3 sum = vec3(0);
    float count = 0.0;
    for (uint i = 2 * corner_starts[vertex]; i < 2 * corner_starts[vertex + 1]; ++i) {
        uvec3 corner = turned(triangles[corners[i / 2]], first + vertex);
        uint other = (i % 2 == 0 ? corner.y : corner.z) - first;
        // Corners without a curvature of their own may be written at the same time; they do not count.
        bool counts = curvature[other].area > 0.0;
        if (counts) sum += vec3(curvature[other].kappa, curvature[other].mean, curvature[other].gaussian);
        count += counts ? 1.0 : 0.0;
    }
    if (count == 0.0) return;
    curvature[vertex].kappa = sum.x / count;
    curvature[vertex].mean = sum.y / count;
    curvature[vertex].gaussian = sum.z / count;
}
