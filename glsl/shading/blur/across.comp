#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Blurs a sheet along its rows.
READS(irradiance_maps)
WRITES(blurred_rows)
#define AXIS 0
#define FETCH(k) irradiance_maps[from + (k)]
uint from;
#include "shading/blur/weighted_mean.glsl"

void main() {
    uint k = invocation();
    Unwrapping own = unwrappings[number];
    if (k >= own.side * own.side) return;
    from = level * texel_hits.length() + own.first;
    blurred_rows[own.first + k] = mean(own, k);
}
