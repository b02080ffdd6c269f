#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The vertices that belong to a triangle: those around which it is the first.
READS(frame)
READS(positions)
READS(triangles)
READS(corner_starts)
READS(corners)
READS(leaves)
WRITES(crowds)
#include "layers/crowd.glsl"

void main() {
    uint face = invocation();
    if (face >= frame[0].faces) return;
    Crowd crowd = Crowd(0.0, vec3(0), vec3(0), vec3(0));
    for (uint k = 0; k < 3; ++k) {
        uint vertex = triangles[face][k];
        bool own = corners[corner_starts[vertex - frame[0].first_vertex]] == face;
        crowd = joined(crowd, Crowd(own ? 1.0 : 0.0, positions[vertex], vec3(0), vec3(0)));
    }
    crowds[leaves[face]] = crowd;
}
