#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// Equation 3: the radiance that leaves the surface towards the eye, from the radiosity interpolated between vertices,
// or that at the very point. Stage `texture_out` multiplies it by the texture.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(constant_id = 1) const uint PIXELS = 0;
READS(object_params)
READS(camera)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(vertex_radiosity)
READS(radiosity)
READS(hits)
READS(seen)
WRITES(radiance)
#include "geometry/blend.glsl"
#include "lighting/leaving.glsl"
#include "view/object.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    vec3 color = camera[0].background;
    if (hit.face < UNFINISHED) {
        uint object = object_of(hit.face);
        uvec3 corner = triangles[hit.face];
        vec3 weight = CORNER_WEIGHTS(hit);
        vec3 point = BLEND_AT(weight, placed_positions, corner);
        vec3 normal = BLEND_AT(weight, placed_normals, corner);
        vec3 B = BLEND_AT(weight, vertex_radiosity, corner);
        if (PIXELS != 0) {
            if (object_params[object].by_pixel != 0) B = radiosity[object_params[object].first_receiver + seen[pixel]];
        }
        vec3 toward = camera[0].origin - point;
        float cosine = facet_cosine(SEEN_COSINE(normal, toward, corner), object_params[object].facet_tilt);
        color = transmittance(object_params[object].eta, cosine) * B * (camera[0].radiance / 3.14159265358979) *
                object_params[object].exit;
    }
    radiance[pixel] = color;
}
