#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A cell of the CDRF's table in one word. Changes are whole numbers of steps from the first corner's rounded value.
layout(constant_id = 0) const uint SIDE = 2;
READS(cdrf_grid)
WRITES(cdrf_cells)

void main() {
    uint k = invocation();
    if (k >= (SIDE - 1) * (SIDE - 1)) return;
    uint corner = k / (SIDE - 1) * SIDE + k % (SIDE - 1);
    precise float first = min(floor(cdrf_grid[corner] * 8192.0 + 0.5), 8191.0), from = first * (1.0 / 8192.0);
    vec3 others = vec3(cdrf_grid[corner + 1], cdrf_grid[corner + SIDE], cdrf_grid[corner + SIDE + 1]);
    precise vec3 steps = floor((others - from) * (31.0 * float(SIDE - 1)) + 0.5);
    int x = clamp(int(steps.x), 0, 63), y = clamp(int(steps.y), -64, 63), both = clamp(int(steps.z) - x - y, -32, 31);
    cdrf_cells[k] = uint(first) | uint(x) << 13 | uint(both & 0x3f) << 19 | uint(y) << 25;
}
