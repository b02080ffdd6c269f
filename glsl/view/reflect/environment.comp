#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// The environment's reflection: its image along fixed directions about the mirror direction, or from fixed microfacets.
layout(constant_id = 0) const uint GGX = 0;
layout(constant_id = 1) const uint COUNT = 1;
layout(push_constant, scalar) uniform push_block { uint object; }; // whose pixels this dispatch shades
READS(object_params)
READS(camera)
READS(sky)
READS(reflection_directions)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(hits)
UPDATES(radiance)
#include "lighting/sky.glsl"
#include "view/surface.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face < object_params[object].first_face || hit.face >= object_params[object].first_face + object_params[object].faces) return;
    Surface s = surface(hit);
    float signed_seen = dot(s.normal, s.toward), seen = abs(signed_seen), alpha = object_params[object].roughness;
    vec3 mirror = 2.0 * signed_seen * s.normal - s.toward;

    // The lobe's axis, and two across it: the picture's right and up.
    vec3 axis = GGX != 0 ? s.normal : mirror;
    vec3 across = unit(camera[0].right);
    across -= dot(across, axis) * axis;
    if (dot(across, across) < 1e-6) across = camera[0].up - dot(camera[0].up, axis) * axis;
    across = unit(across);
    vec3 other = cross(axis, across);
    vec3 sum = vec3(0);
    for (uint k = 0; k < COUNT; ++k) {
        vec3 local = reflection_directions[object * COUNT + k], direction = local.x * across + local.y * other + local.z * axis;
        float met, weight;
        if (GGX != 0) {
            met = max(dot(s.toward, direction), 0.0);
            direction = 2.0 * met * direction - s.toward;
            float cosine = max(dot(s.normal, direction), 0.0);
            weight = 4.0 * cosine * masking(alpha, seen, cosine) * met / local.z;
        } else {
            met = max(dot(s.normal, direction), 0.0);
            weight = met * (alpha + 2.0) / (alpha + 1.0);
        }
        sum += sky_toward(direction) * weight * (1.0 - transmittance(object_params[object].eta, met));
    }
    radiance[pixel] += camera[0].radiance / float(COUNT) * sum;
}
