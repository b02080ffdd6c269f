#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The moments of the vertices that a triangle owns: those whose list of triangles it heads.
READS(object_params)
READS(positions)
READS(triangles)
READS(corner_starts)
READS(corners)
READS(leaves)
WRITES(vertex_moments)
#include "layers/vertex_moments.glsl"

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    VertexMoments crowd = VertexMoments(0.0, vec3(0), vec3(0), vec3(0));
    for (uint k = 0; k < 3; ++k) {
        uint vertex = triangles[face][k];
        bool own = corners[corner_starts[vertex - object_params[0].first_vertex]] == face;
        crowd = joined(crowd, VertexMoments(own ? 1.0 : 0.0, positions[vertex], vec3(0), vec3(0)));
    }
    vertex_moments[leaves[face]] = crowd;
}
