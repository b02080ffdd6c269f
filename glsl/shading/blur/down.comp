#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Blurs the sheet that is blurred along its rows down its columns, which gives the next sheet.
READS(blurred_rows)
UPDATES(irradiance_maps)
#define AXIS 1
#define FETCH(k) blurred_rows[own.first + (k)]
#include "shading/blur/weighted_mean.glsl"

void main() {
    uint k = invocation();
    Unwrapping own = unwrappings[number];
    if (k >= own.side * own.side) return;
    irradiance_maps[(level + 1) * texel_hits.length() + own.first + k] = mean(own, k);
}
