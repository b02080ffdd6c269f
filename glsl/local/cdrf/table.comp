#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

READS(frame)
#include "local/bend.glsl"

// The curvature-dependent reflectance function from its table.
layout(constant_id = 4) const uint SIDE = 2;
READS(cdrf_cells)
#include "local/lookup.glsl"

vec3 respond(float c, vec3 sigma) {
    return lookup(c, sigma);
}
#include "local/diffuse.glsl"
