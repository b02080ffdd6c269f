#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Where the light that enters each triangle collides first, and how much of it does: one ray for each light, and one
// for the environment.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
READS(object_params)
READS(lights)
READS(leaves)
READS(clusters)
READS(triangles)
READS(positions)
READS(bounds)
READS(lit)
READS(irradiance)
WRITES(deposits)
#include "geometry/sight.glsl"
#include "geometry/turn.glsl"
#include "geometry/placed.glsl"
#include "transport/walk/exact.glsl"
#include "transport/walk/entered.glsl"
#include "transport/walk/hit.glsl"

// The share of light that collides within `tau` mean free paths, and the mean depth of its collisions, in mean free
// paths.
vec2 collides(float tau) {
    float fall = exp(-tau);
    float share = tau < 0.05 ? tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau / 24.0))) : 1.0 - fall;
    float small = tau * (0.5 - tau * (1.0 / 12.0 - tau * tau / 720.0));
    return vec2(share, tau < 0.5 ? small : 1.0 - tau * fall / share);
}

// The distance through the object along a direction.
float thickness(vec3 center, vec3 way, uint face) {
    vec3 weights;
    uint found = meeting(center, way, 8.0, face, weights);
    if (found == NONE || found == UNFINISHED) return 1e30;
    uvec3 corner = triangles[found];
    float sum = weights.x + weights.y + weights.z;
    vec3 place = (weights.x * positions[corner.x] + weights.y * positions[corner.y] + weights.z * positions[corner.z]) / sum;
    return max(0.0, dot(place - center, way));
}

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x];
    precise vec3 b = positions[corner.y] - a;
    precise vec3 c = positions[corner.z] - a;
    precise vec3 large = FAR_FROM_DENORMAL * cross3(b, c);
    vec3 normal = unit_of(large), center = clusters[leaves[face]].center;
    vec3 place = placed(0, center), out_there = turned(0, normal);
    vec3 sums[3] = vec3[3](vec3(0), vec3(0), vec3(0));
    float light[3] = float[3](0.0, 0.0, 0.0), all[3] = float[3](0.0, 0.0, 0.0);
    for (uint i = 0; i <= object_params[0].lights; ++i) {
        bool sky = i == object_params[0].lights;
        if (sky && SKY == 0) break;
        // Channels with the same index of refraction share a direction, and its ray.
        vec3 known_way = vec3(0);
        float known = 0.0;
        for (uint channel = 0; channel < 3; ++channel) {
            float eta = object_params[0].eta[channel], one, path;
            vec3 way = -normal;
            if (sky) {
                one = irradiance[face][channel] - all[channel];
                path = object_params[0].sky_depth[channel];
            } else {
                vec3 toward;
                one = entered(lights[i], channel, face, place, out_there, toward);
                way = refracted(eta, turned_back(toward), normal);
                path = object_params[0].z_real[channel];
            }
            if (one > 0.0) {
                if (way != known_way) known = thickness(center, way, face);
                known_way = way;
                vec2 found = collides(min(known / max(path, 1e-30), 80.0));
                all[channel] += one;
                light[channel] += one * found.x;
                sums[channel] += one * found.x * found.y * path * way;
            }
        }
    }
    vec3 whole = vec3(all[0], all[1], all[2]), some = vec3(light[0], light[1], light[2]);
    vec3 share = mix(vec3(0), some / max(whole, vec3(1e-37)), greaterThan(whole, vec3(0)));
    vec3 by = mix(vec3(0), 1.0 / max(some, vec3(1e-37)), greaterThan(some, vec3(0)));
    deposits[face] = Deposit(sums[0] * by.x, sums[1] * by.y, sums[2] * by.z,
                             12.5663706 * object_params[0].strength * irradiance[face] * share);
}
