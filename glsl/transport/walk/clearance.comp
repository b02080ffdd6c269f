#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// For each cell of a grid around an object, a lower bound on the distance of its points from the surface.
READS(object_params)
READS(bounds)
WRITES(clearance)
#include "geometry/sight.glsl"
#include "geometry/turn.glsl"
#include "transport/walk/exact.glsl"

void main() {
    uint cell = invocation();
    if (cell >= CLEARANCE_SIDE * CLEARANCE_SIDE * CLEARANCE_SIDE) return;
    vec3 low = bounds[0].low, high = bounds[0].high;
    precise vec3 step_of = (high - low) * (1.0 / float(CLEARANCE_SIDE));
    uvec3 at = uvec3(cell, cell / CLEARANCE_SIDE, cell / (CLEARANCE_SIDE * CLEARANCE_SIDE)) % CLEARANCE_SIDE;
    precise vec3 center = low + (vec3(at) + 0.5) * step_of;
    float best = 16.0;
    uint node = 0, nodes = object_params[0].nodes, first = object_params[0].first_node;
    while (node < nodes) {
        Bounds box = bounds[node];
        precise vec3 below = box.low - center;
        precise vec3 above = center - box.high;
        vec3 apart = max(max(below, above), vec3(0));
        float square = dot3(apart, apart);
        bool leaf = box.face != NONE, nearer = square < best;
        if (leaf && nearer) best = square;
        node = nearer && !leaf ? node + 1 : box.next - first;
    }
    // 0.9999 and 1e-5 cover rounding.
    float square = dot3(step_of, step_of);
    precise float least = 0.9999 * root_of(best) - 0.5 * root_of(square) - 1e-5;
    clearance[cell] = node < nodes ? 0.0 : max(least, 0.0);
}
