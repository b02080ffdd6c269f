#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A vertex and its normal in the scene.
READS(object_params)
READS(positions)
READS(normals)
UPDATES(placed_positions)
WRITES(placed_normals)
#include "geometry/placed.glsl"

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    uint place = object_params[0].first_vertex + vertex;
    placed_positions[place] = placed(0, positions[place]);
    placed_normals[vertex] = turned(0, normals[vertex]);
}
