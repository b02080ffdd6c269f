#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Multiplies the light that enters a face by the texture's mean over it, from the centroids of equal parts.
READS(object_params)
READS(corner_uvs)
READS(texels)
UPDATES(irradiance)
#include "lighting/texture.glsl"

// The longest extent of an edge along either side of the texture, in texels.
float longest(CornerUvs uvs) {
    vec2 size = vec2(object_params[0].texture_size);
    precise vec2 ab = abs(uvs.b - uvs.a) * size, bc = abs(uvs.c - uvs.b) * size, ca = abs(uvs.a - uvs.c) * size;
    vec2 most = max(max(ab, bc), ca);
    return max(most.x, most.y);
}

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces || (object_params[0].texture_side & TEXTURE_ENTERS) == 0) return;
    CornerUvs uvs = corner_uvs[face];
    uint n = uint(clamp(ceil(longest(uvs)), 1.0, float(TEXTURE_PARTS)));
    vec3 sum = vec3(0);
    for (uint k = 0; k < n * n; ++k) {
        uvec2 cell = uvec2(k / n, k % n);
        // Inverted parts lie beyond the diagonal, and are counted from the far corner.
        bool upright = cell.x + cell.y < n;
        vec2 corner = vec2(upright ? cell : n - 1 - cell);
        sum += texture_factor(0, texture_place(uvs, (corner + (upright ? 1.0 : 2.0) / 3.0) / float(n)));
    }
    irradiance[face] *= sum / float(n * n);
}
