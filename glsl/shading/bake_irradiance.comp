#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The light that enters at each texel, and the lengths that the texel spans.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
layout(constant_id = 2) const uint TEXTURED = 0;
layout(push_constant, scalar) uniform push_block { uint number; };
READS(object_params)
READS(lights)
READS(lit)
READS(harmonics)
READS(triangles)
READS(placed_positions)
READS(placed_normals)
READS(corner_uvs)
READS(texels)
READS(unwrappings)
READS(texel_hits)
UPDATES(irradiance_maps)
WRITES(stretch)
#include "geometry/blend.glsl"
#include "lighting/entering.glsl"
#include "lighting/texture.glsl"

void main() {
    uint k = invocation();
    Unwrapping own = unwrappings[number];
    if (k >= own.side * own.side) return;
    TexelHit chart = texel_hits[own.first + k];
    vec4 light = vec4(0);
    vec2 lengths = vec2(0);
    if (chart.face != NONE) {
        uvec3 corner = triangles[chart.face];
        vec3 weight = CORNER_WEIGHTS(chart);
        vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
        vec3 normal = BLEND_AT(weight, placed_normals, corner);
        normal /= sqrt(max(dot(normal, normal), 1e-30));
        vec3 E = entering(own.object, chart.face, BLEND(weight, a, b, c), normal);
        CornerUvs uvs = corner_uvs[chart.face];
        if (TEXTURED != 0) {
            bool enters = (object_params[own.object].texture_side & TEXTURE_ENTERS) != 0;
            if (enters) E *= texture_factor(own.object, texture_place(uvs, vec2(chart.u, chart.v)));
        }
        light = vec4(E, 1.0);

        // Positions are linear in the texture coordinates.
        vec2 p = uvs.b - uvs.a, q = uvs.c - uvs.a;
        precise float turned = p.x * q.y - p.y * q.x;
        vec3 along = (b - a) * q.y - (c - a) * p.y, down = (c - a) * p.x - (b - a) * q.x;
        float over = 1.0 / (abs(turned) * float(own.side));
        vec2 longest = vec2(LONGEST_STRETCH);
        lengths = turned == 0.0 ? longest : min(vec2(length(along), length(down)) * over, longest);
    }
    irradiance_maps[own.first + k] = light;
    stretch[own.first + k] = lengths;
}
