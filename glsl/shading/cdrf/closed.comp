#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

READS(object_params)
#include "shading/closed.glsl"
#include "shading/local_sigma.glsl"

// The curvature-dependent reflectance function in closed form.
vec3 respond(float c, vec3 sigma) {
    return cdrf(c, sigma);
}
#include "shading/diffuse.glsl"
