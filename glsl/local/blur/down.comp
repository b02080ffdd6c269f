#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Down the columns of the sheet that is blurred along its rows: gives the next sheet.
READS(crossed)
UPDATES(sheets)
#define AXIS 1
#define FETCH(k) crossed[own.first + (k)]
#include "local/blur/mean.glsl"

void main() {
    uint k = invocation();
    Unwrapping own = unwrappings[number];
    if (k >= own.side * own.side) return;
    sheets[(level + 1) * charts.length() + own.first + k] = mean(own, k);
}
