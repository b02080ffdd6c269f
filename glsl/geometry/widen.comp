#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The box of one child of a wide node.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(wide_links)
READS(placed_bounds)
WRITES(wide_boxes)

void main() {
    uint child = invocation();
    if (child >= range.count) return;
    uvec2 link = wide_links[child];
    bool there = link.x != NONE;
    Bounds own = placed_bounds[there ? link.x : 0];
    wide_boxes[child] = there ? Bounds(own.low, link.y, own.high, own.face) : Bounds(vec3(NO_BOX), 0, vec3(-NO_BOX), 0);
}
