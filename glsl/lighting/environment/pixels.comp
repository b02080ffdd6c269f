#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Image times harmonics over SKY_BLOCK pixels of a row. Every harmonic is the product of a function of the row and one
// of the column, whose integrals over a pixel are exact.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(sky)
READS(sky_rows)
READS(sky_columns)
WRITES(harmonics)

void main() {
    uint k = invocation();
    if (k >= range.count) return;
    uint width = object_params[0].sky.x, across = (width + SKY_BLOCK - 1) / SKY_BLOCK;
    uint row = k / across, start = k % across * SKY_BLOCK, end = min(start + SKY_BLOCK, width);
    vec3 one = vec3(0), x = vec3(0), z = vec3(0), xz = vec3(0), difference = vec3(0);
    for (uint column = start; column < end; ++column) {
        vec3 radiance = sky[row * width + column];
        SkyColumn c = sky_columns[column];
        one += c.first.x * radiance;
        x += c.first.y * radiance;
        z += c.first.z * radiance;
        xz += c.second.x * radiance;
        difference += c.second.y * radiance;
    }
    SkyRow r = sky_rows[row];
    uint at = SKY_HARMONICS * (range.first + k);
    harmonics[at] = 0.28209479 * r.first.x * one;
    harmonics[at + 1] = 0.48860251 * r.first.z * x;
    harmonics[at + 2] = 0.48860251 * r.first.y * one;
    harmonics[at + 3] = 0.48860251 * r.first.z * z;
    harmonics[at + 4] = 1.09254843 * r.second.y * z;
    harmonics[at + 5] = 1.09254843 * r.second.z * xz;
    harmonics[at + 6] = 1.09254843 * r.second.y * x;
    harmonics[at + 7] = 0.31539157 * (3.0 * r.second.x - r.first.x) * one;
    harmonics[at + 8] = 0.54627421 * r.second.z * difference;
}
