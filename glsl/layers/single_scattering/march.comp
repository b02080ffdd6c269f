#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// One light at one sample of each view ray: where the light enters on its way there, and how much is scattered towards
// the eye between the previous sample and this one.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(push_constant, scalar) uniform push_block { uint number, beam, sample_number, first_pixel, last_pixel; };
READS(object_params)
READS(camera)
READS(lit)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(placed_bounds)
READS(hits)
READS(scattering_media)
READS(layer_lights)
UPDATES(inner_rays)
UPDATES(radiance)
UPDATES(cut_short)
#include "geometry/blend.glsl"
#include "geometry/sight.glsl"
#include "lighting/arrival.glsl"
#include "lighting/fresnel.glsl"
#include "layers/segment.glsl"
#include "layers/single_scattering/leaving.glsl"

// Henyey and Greenstein's phase function, in sums of positive terms.
vec3 phase(vec3 g, float cosine) {
    vec3 size = abs(g), rest = 1.0 - size;
    vec3 base = rest * rest + 2.0 * size * max(1.0 + sign(g) * cosine, 0.0);
    return rest * (1.0 + size) / (4.0 * 3.14159265358979 * base * sqrt(base));
}

void main() {
    uint pixel = first_pixel + invocation();
    if (pixel >= last_pixel) return;
    Hit hit = hits[pixel];
    ScatteringMedium own = scattering_media[number];
    uint first_face = object_params[own.object].first_face;
    if (hit.face < first_face || hit.face >= first_face + object_params[own.object].faces) return;
    InnerRay ray = inner_rays[pixel - first_pixel];
    if (!(ray.end > 0.0)) return;
    Light light = layer_lights[beam];

    // Decisions: the sample, and the triangle that a straight ray from there to the light leaves through.
    uvec3 corner = triangles[hit.face];
    precise vec3 weight = CORNER_WEIGHTS(hit);
    vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
    precise vec3 point = BLEND(weight, a, b, c);
    precise float share = float(sample_number * sample_number) * (1.0 / float(SINGLE_STEPS * SINGLE_STEPS));
    precise float t = share * ray.end;
    precise vec3 place = point + t * ray.way;
    bool far = light.kind == LIGHT_DIRECTIONAL;
    precise vec3 direction = light.place;
    if (!far) direction = light.place - place;
    precise vec3 right = b - a;
    precise vec3 up = c - a;
    Nearest entry = Nearest(hit.face, weight, 0.0, 1.0);
    if (sample_number > 0 || dot3(direction, cross3(right, up)) <= 0.0) entry = leaving(own.object, place, direction);
    if (entry.face == UNFINISHED) cut_short[0] = 1;
    bool enters = entry.face < UNFINISHED && (far || entry.numerator < entry.denominator);

    // The light that arrives, and the length of its way in the medium.
    vec3 arrives = vec3(0), eye = camera[0].origin - point, normal = BLEND_AT(weight, placed_normals, corner);
    eye /= sqrt(max(dot(eye, eye), 1e-30));
    normal /= sqrt(max(dot(normal, normal), 1e-30));
    float leg = 0.0;
    if (enters) {
        uvec3 met = triangles[entry.face];
        vec3 shares = entry.weights / (entry.weights.x + entry.weights.y + entry.weights.z);
        vec3 out_there = BLEND_AT(shares, placed_normals, met);
        out_there /= sqrt(max(dot(out_there, out_there), 1e-30));
        vec3 straight = max(entry.numerator / entry.denominator, 0.0) * direction;
        vec3 toward = direction / sqrt(max(dot(direction, direction), 1e-30));
        float outer = clamp(dot(out_there, toward), 0.0, 1.0);
        float passes = transmittance(vec3(own.eta), outer).x;
        float inner = own.eta == 1.0 ? outer : sqrt(max(outer * outer - (1.0 - own.eta) * (1.0 + own.eta), 0.0)) / own.eta;
        float ratio = passes > 0.0 ? outer / inner : 0.0;
        vec3 bent = (toward - outer * out_there) / own.eta + inner * out_there;
        leg = length(straight) * ratio;
        // Inside, light from a place falls off as if it had gone leg / eta.
        vec3 seen = place + straight - toward * (leg / own.eta);
        float falloff = arrival(light, seen, toward) * reaches(light, entry.face);
        arrives = light.color * (falloff * passes * ratio) * phase(own.g, -dot(bent, ray.way));
    }

    vec3 depth = own.sigma_t * (t + leg);
    if (sample_number > 0) {
        float before = float((sample_number - 1) * (sample_number - 1)) * (1.0 / float(SINGLE_STEPS * SINGLE_STEPS));
        vec3 scattered = segment(ray.arrived, arrives, exp(-ray.depth), exp(-depth), depth - ray.depth);
        float leaves = transmittance(vec3(own.eta), abs(dot(normal, eye))).x / (own.eta * own.eta);
        radiance[pixel] += camera[0].radiance * leaves * (share - before) * ray.end * own.sigma_s * scattered;
    }
    inner_rays[pixel - first_pixel].arrived = arrives;
    inner_rays[pixel - first_pixel].depth = depth;
}
