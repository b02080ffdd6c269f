#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "local/closed.glsl"

// A cell of the CDRF's table: the values at its corners.
layout(constant_id = 0) const uint SIDE = 2;
WRITES(cdrf_cells)

float entry(uint column, uint row) {
    float last = float(SIDE - 1);
    return cdrf(2.0 * float(column) / last - 1.0, vec3(3.5 * float(row) / last)).x;
}

void main() {
    uint k = invocation();
    if (k >= (SIDE - 1) * (SIDE - 1)) return;
    uint column = k % (SIDE - 1), row = k / (SIDE - 1);
    cdrf_cells[k] = vec4(entry(column, row), entry(column + 1, row), entry(column, row + 1), entry(column + 1, row + 1));
}
