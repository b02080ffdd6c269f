#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Along the rows of a sheet.
READS(sheets)
WRITES(crossed)
#define AXIS 0
#define FETCH(k) sheets[from + (k)]
uint from;
#include "local/blur/mean.glsl"

void main() {
    uint k = invocation();
    Unwrapping own = unwrappings[number];
    if (k >= own.side * own.side) return;
    from = level * charts.length() + own.first;
    crossed[own.first + k] = mean(own, k);
}
