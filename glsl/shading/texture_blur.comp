#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "lighting/fresnel.glsl"

// Radiance of a pixel from the light blurred over the texture, bilinear between the texels that show a surface.
layout(constant_id = 0) const uint OBJECTS = 1;
READS(object_params)
READS(camera)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(hits)
READS(corner_uvs)
READS(unwrappings)
READS(gaussians)
READS(irradiance_maps)
UPDATES(radiance)
#include "geometry/blend.glsl"
#include "lighting/leaving.glsl"
#include "lighting/wrap.glsl"
#include "view/object.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face >= UNFINISHED) {
        radiance[pixel] = camera[0].background;
        return;
    }
    uint object = object_of(hit.face), sheet = object_params[object].irradiance_map;
    if (sheet == 0) return;
    Unwrapping own = unwrappings[sheet - 1];

    // Whole repetitions are subtracted: if an edge of the texture does not continue at the opposite edge, the triangle
    // lies within one repetition.
    CornerUvs uvs = corner_uvs[hit.face];
    vec2 place = texture_place(uvs, vec2(hit.u, hit.v)), middle = floor(texture_place(uvs, vec2(1.0 / 3.0)));
    vec2 at = float(own.side) * (place - middle) - 0.5, low = floor(at), part = at - low;
    uvec2 wraps = uvec2(equal(own.round, uvec2(0)));
    int x = int(low.x), y = int(low.y);
    uint left = wrapped(wraps.x, x, own.side), right = wrapped(wraps.x, x + 1, own.side);
    uint above = wrapped(wraps.y, y, own.side) * own.side, below = wrapped(wraps.y, y + 1, own.side) * own.side;
    vec3 sum = vec3(0);
    uint first = own.first;
    for (uint k = 0; k < GAUSSIANS; ++k) {
        first += irradiance_maps.length() / (GAUSSIANS + 1);
        vec4 light = mix(mix(irradiance_maps[first + above + left], irradiance_maps[first + above + right], part.x),
                         mix(irradiance_maps[first + below + left], irradiance_maps[first + below + right], part.x), part.y);
        sum += gaussians[GAUSSIANS * (sheet - 1) + k].rgb * light.rgb / max(light.a, 1e-30);
    }

    uvec3 corner = triangles[hit.face];
    vec3 weight = CORNER_WEIGHTS(hit);
    vec3 point = BLEND_AT(weight, placed_positions, corner);
    vec3 normal = BLEND_AT(weight, placed_normals, corner);
    normal /= sqrt(max(dot(normal, normal), 1e-30));
    vec3 eye = camera[0].origin - point;
    float cosine = facet_cosine(SEEN_COSINE(normal, eye, corner), object_params[object].facet_tilt);
    vec3 leaves = transmittance(object_params[object].eta, cosine) * object_params[object].exit;
    radiance[pixel] = leaves * sum * (camera[0].radiance / 3.14159265358979);
}
