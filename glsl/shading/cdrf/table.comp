#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

READS(object_params)
#include "shading/local_sigma.glsl"

// The curvature-dependent reflectance function from its table.
layout(constant_id = 4) const uint SIDE = 2;
READS(cdrf_cells)
#include "shading/lookup.glsl"

vec3 respond(float c, vec3 sigma) {
    return lookup(c, sigma);
}
#include "shading/diffuse.glsl"
