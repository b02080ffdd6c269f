// The march beneath one visible point: its ray, the layers along it, and the light that arrives there.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint MAPS = 1;
layout(constant_id = 2) const uint MAPPED = MAPPED_NOT;
layout(constant_id = 3) const uint HENYEY = 0;
layout(constant_id = 4) const uint FRESNEL = 0;
// The layering, and the lights and pixels of this dispatch.
layout(push_constant, scalar) uniform push_block { uint number, first_beam, last_beam, first_pixel, last_pixel; };
READS(object_params)
READS(camera)
READS(lit)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(planes)
READS(corner_uvs)
READS(hits)
READS(layerings)
READS(layer_media)
READS(depths)
READS(islands)
READS(layer_lights)
UPDATES(radiance)
#include "geometry/blend.glsl"
#include "geometry/placed.glsl"
#include "lighting/arrival.glsl"
#include "lighting/fresnel.glsl"
#include "lighting/wrap.glsl"

const uint MOST_MAPS = MOST_LAYERS / MAP_LAYERS;

struct March {
    vec3 point, normal, plane_point, plane_normal; // the surface at P, and the fitted plane
    vec3 eye;                                      // direction towards the eye
    vec2 place;                                    // P's place in the maps
    vec3 du, dv;                                   // gradients of the place
    vec2 low, high;                                // the bounds of P's island in the maps
    float slope;                                   // depth gained per length
    float reach;                                   // length of the ray
};

vec3 unit(vec3 v) { return v * (1.0 / sqrt(max(dot(v, v), 1e-30))); }

March march(Layering own, Hit hit) {
    uvec3 corner = triangles[hit.face];
    vec3 weight = CORNER_WEIGHTS(hit);
    vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
    vec4 plane = BLEND_AT(weight, planes, corner);
    March m;
    m.point = BLEND(weight, a, b, c);
    m.eye = unit(camera[0].origin - m.point);
    vec3 area = cross(b - a, c - a), fitted = unit(turned(own.object, plane.xyz));
    float side = dot(area, m.eye) < 0.0 ? -1.0 : 1.0;
    m.normal = side * unit(BLEND_AT(weight, placed_normals, corner));
    m.plane_normal = side * fitted;
    m.plane_point = m.point + plane.w * fitted;
    m.place = vec2(0);
    m.du = vec3(0);
    m.dv = vec3(0);
    m.low = vec2(0);
    m.high = vec2(0);
    if (MAPPED != MAPPED_NOT) {
        CornerUvs uvs;
        if (MAPPED == MAPPED_BY_ISLANDS) {
            Island island = islands[hit.face - object_params[own.object].first_face + own.first_island];
            uvs = CornerUvs(island.a, island.b, island.c);
            m.low = island.low;
            m.high = island.high;
        } else {
            uvs = corner_uvs[hit.face];
        }
        m.place = BLEND(weight, uvs.a, uvs.b, uvs.c);
        vec2 p = uvs.b - uvs.a, q = uvs.c - uvs.a;
        vec3 x = cross(c - a, area), y = cross(area, b - a);
        float square = dot(area, area);
        if (square > 0.0) {
            m.du = (p.x * x + q.x * y) / square;
            m.dv = (p.y * x + q.y * y) / square;
        }
    }
    m.slope = max(dot(m.plane_normal, m.eye), GRAZING);
    m.reach = min(own.deepest / m.slope, own.reach);
    return m;
}

// The four texels around a place in a map, and its offset from the first, in texels.
struct Texels {
    uvec4 at;
    vec2 part;
};

Texels texels_at(Layering own, March m, vec3 offset) {
    vec2 place = m.place + vec2(dot(m.du, offset), dot(m.dv, offset));
    if (MAPPED == MAPPED_BY_ISLANDS) {
        // There is no texel beyond the last one of a margin.
        place = clamp(place, m.low, m.high);
        vec2 low = floor(place);
        uvec2 first = uvec2(low), last = min(first + 1u, uvec2(m.high));
        uint above = own.first_texel + first.y * own.size.x, below = own.first_texel + last.y * own.size.x;
        return Texels(uvec4(above + first.x, above + last.x, below + first.x, below + last.x), place - low);
    }
    // The place is brought within the range of integers.
    if (own.wrap == WRAP_REPEAT) place -= floor(place);
    if (own.wrap == WRAP_CLAMP) place = clamp(place, vec2(-1), vec2(2));
    if (own.wrap == WRAP_MIRROR) place -= 2.0 * floor(0.5 * place);
    vec2 at = vec2(own.size) * place - 0.5, low = floor(at);
    int x = int(low.x), y = int(low.y);
    uint left = wrapped(own.wrap, x, own.size.x), right = wrapped(own.wrap, x + 1, own.size.x);
    uint above = wrapped(own.wrap, y, own.size.y) * own.size.x;
    uint below = wrapped(own.wrap, y + 1, own.size.y) * own.size.x;
    return Texels(own.first_texel + uvec4(above + left, above + right, below + left, below + right), at - low);
}

// Depths of the lower interfaces of a map's four layers at these texels.
vec4 depths_of(Layering own, Texels t, uint map) {
    if (MAPPED == MAPPED_NOT) return depths[own.first_texel + map];
    uvec4 at = t.at + map * own.size.x * own.size.y;
    return mix(mix(depths[at.x], depths[at.y], t.part.x), mix(depths[at.z], depths[at.w], t.part.x), t.part.y);
}

// How many of a map's interfaces lie at or above a depth.
uint above(vec4 interfaces, float depth) {
    uvec4 counts = uvec4(greaterThanEqual(vec4(depth), interfaces));
    return counts.x + counts.y + counts.z + counts.w;
}

// The phase function at two cosines.
vec2 phase(float g, vec2 cosine) {
    // 1 + g^2 + 2 g c, or 1 + g c, as sums of positive terms.
    float size = abs(g);
    vec2 past = size * max(1.0 + (g < 0.0 ? -cosine : cosine), 0.0);
    vec2 base = HENYEY != 0 ? (1.0 - size) * (1.0 - size) + 2.0 * past : 1.0 - size + past;
    vec2 power = HENYEY != 0 ? base * sqrt(base) : base * base;
    return (1.0 - size) * (1.0 + size) / (4.0 * 3.14159265358979 * power.x * power.y) * power.yx;
}

// A light at a place: the share that would arrive without dimming, the optical depth of its path in the layers, and the
// cosine for the phase function.
struct Lit {
    vec3 arrives;
    vec3 dimmed;
    float cosine;
};

// `here` are the depths of the interfaces at that place, `t` is its distance along the ray.
Lit lit_at(Layering own, March m, uint object, Light light, uint face, float t, vec4 here[MOST_MAPS]) {
    vec3 place = m.point - t * m.eye, toward;
    float falloff = arrival(light, place, toward) * reaches(light, face);

    // The plane between the tangent one and the fitted one, and where light comes through it.
    float share = t / m.reach;
    vec3 normal = unit(mix(m.normal, m.plane_normal, share));
    float depth = max(dot(mix(m.point, m.plane_point, share) - place, normal), 0.0);
    float facing = dot(normal, toward), cosine = max(facing, LEAST_COSINE);
    // No light enters from behind.
    falloff *= clamp(facing / FADING, 0.0, 1.0);
    Texels entry;
    if (MAPPED != MAPPED_NOT) entry = texels_at(own, m, place + toward * (depth / cosine) - m.point);

    vec3 sum = vec3(0);
    float before = 0.0;
    for (uint map = 0; map < MAPS; ++map) {
        vec4 bottoms = MAPPED != MAPPED_NOT ? 0.5 * (here[map] + depths_of(own, entry, map)) : here[map];
        for (uint k = 0; k < MAP_LAYERS; ++k) {
            uint layer = MAP_LAYERS * map + k;
            float bottom = layer + 1 < own.layers ? min(bottoms[k], depth) : depth;
            sum += layer_media[own.first_layer + min(layer, own.layers - 1)].sigma_t * (bottom - before);
            before = bottom;
        }
    }
    vec3 arrives = vec3(falloff);
    if (FRESNEL != 0) arrives *= transmittance(object_params[object].eta, cosine);
    return Lit(arrives, sum * (1.0 / cosine), dot(toward, m.eye));
}

// Adds light to a pixel.
void shine(uint pixel, uint object, March m, vec3 sum) {
    if (FRESNEL != 0) sum *= transmittance(object_params[object].eta, abs(dot(m.normal, m.eye)));
    radiance[pixel] += camera[0].radiance * sum;
}
