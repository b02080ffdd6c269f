#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The view ray beneath each point that a pixel shows, from where it is refracted to where it leaves the object.
// Decisions only: samples lie along it.
layout(push_constant, scalar) uniform push_block { uint number, first_pixel, last_pixel; };
READS(object_params)
READS(camera)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(placed_bounds)
READS(hits)
READS(scattering_media)
UPDATES(inner_rays)
UPDATES(cut_short)
#include "geometry/blend.glsl"
#include "geometry/sight.glsl"
#include "geometry/exact.glsl"
#include "layers/single_scattering/leaving.glsl"

void main() {
    uint pixel = first_pixel + invocation();
    if (pixel >= last_pixel) return;
    Hit hit = hits[pixel];
    ScatteringMedium own = scattering_media[number];
    uint first_face = object_params[own.object].first_face;
    if (hit.face < first_face || hit.face >= first_face + object_params[own.object].faces) return;
    uvec3 corner = triangles[hit.face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
    precise vec3 point = BLEND(weight, a, b, c);
    precise vec3 blended = BLEND_AT(weight, placed_normals, corner);
    precise vec3 apart = camera[0].origin - point;
    precise vec3 right = b - a;
    precise vec3 up = c - a;

    // A normal that leans away from the eye is mirrored.
    vec3 eye = unit_of(apart);
    vec3 normal = dot3(blended, blended) > 1e-12 ? unit_of(blended) : eye;
    float leaning = dot3(eye, normal);
    precise vec3 mirrored = normal - 2.0 * leaning * eye;
    if (leaning < 0.0) normal = mirrored;
    bool enters = dot3(apart, cross3(right, up)) > 0.0 && inside_of(own.eta, abs(leaning)) > 0.0;

    InnerRay ray = InnerRay(vec3(0), 0.0, vec3(0), vec3(0));
    if (enters) {
        ray.way = refracted(own.eta, eye, normal);
        Nearest last = leaving(own.object, point, ray.way);
        if (last.face == UNFINISHED) cut_short[0] = 1;
        precise float distance = last.numerator * inverse_of(last.denominator);
        ray.end = last.face == NONE ? own.reach : clamp(distance, 0.0, own.reach);
    }
    inner_rays[pixel - first_pixel] = ray;
}
