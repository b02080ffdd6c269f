#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

READS(object_params)

// Lambert's cosine.
vec3 respond(float c, vec3 sigma) {
    return vec3(max(c, 0.0));
}

vec3 local_sigma(vec3 sigma, uint object, uint face, vec3 weight) {
    return vec3(0);
}

mat3 respond_sky(vec3 sigma) {
    return mat3(vec3(3.14159265358979), vec3(2.09439510239320), vec3(0.78539816339745));
}
#include "shading/diffuse.glsl"
