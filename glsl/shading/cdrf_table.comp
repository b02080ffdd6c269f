#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "shading/closed.glsl"

// An entry of the CDRF's table.
layout(constant_id = 0) const uint SIDE = 2;
WRITES(cdrf_grid)

void main() {
    uint k = invocation();
    if (k >= SIDE * SIDE) return;
    float last = float(SIDE - 1);
    cdrf_grid[k] = cdrf(2.0 * float(k % SIDE) / last - 1.0, vec3(CDRF_WIDEST * float(k / SIDE) / last)).x;
}
