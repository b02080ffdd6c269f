#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Whether one light reaches each of some faces: a bit of `lit`. Decisions only.
layout(constant_id = 0) const uint OTHERS = 0; // not 0 where an object does not shadow itself
layout(push_constant, scalar) uniform push_block { Rays rays; };
READS(frame)
READS(lights)
READS(leaves)
READS(clusters)
READS(positions)
READS(triangles)
READS(bounds)
UPDATES(lit)
UPDATES(cut_short)
#include "geometry/trace.glsl"
#include "geometry/plane.glsl"
#include "geometry/occlusion.glsl"

void main() {
    uint k = invocation();
    if (k >= rays.count) return;
    uint face = rays.first + k;
    Light light = lights[rays.light];
    vec3 origin = clusters[frame[rays.object].first_node + leaves[face]].center;
    bool far = light.kind == 0 || light.kind == 5;
    precise vec3 direction = light.place;
    if (!far) direction = light.place - origin;
    uvec3 corner = triangles[face];
    Plane own = plane_of(positions[corner.x], positions[corner.y], positions[corner.z]);

    // A face turned away needs no ray, nor does one behind an area or outside a spot's cone.
    float facing = dot3(direction, own.normal);
    float side = facing > 0.0 ? 1.0 : -1.0;
    float along = -dot3(direction, light.axis);
    precise float cosine = 1.0 - light.outer;
    precise float square = along * along;
    precise float least = cosine * cosine * dot3(direction, direction);
    bool shines = (light.kind != 3 || along > 0.0) && (light.kind != 2 || (along > 0.0 && square > least));
    bool wanted = shines && (OTHERS != 0 || facing > 0.0 || (frame[rays.object].two_sided != 0 && facing < 0.0));
    uvec2 spared = uvec2(frame[rays.object].first_face, frame[rays.object].faces);
    uint met = occlusion(origin, direction, far, light.place, face, own, side, wanted, spared, OTHERS != 0);
    if (met == UNFINISHED) cut_short[0] = 1;

    // The first light of a word clears it.
    uint word = face * frame[0].shadow_words + light.shadow / 32, bit = light.shadow % 32;
    uint others = bit == 0 ? 0 : lit[word];
    lit[word] = others | (wanted && met == FREE ? 1u << bit : 0u);
}
