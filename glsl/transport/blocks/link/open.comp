#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Starts a frame's lists.
UPDATES(counters)

void main() {
    if (invocation() == 0) {
        ListCounters old = counters[0];
        counters[0] = ListCounters(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, old.contrast, old.contrast, 0, 0, 0, 0, 0, 0, 0, 0,
            old.padding, old.more_padding, 0);
    }
}
