#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A block's distant clusters, expanded about its centre: value, gradient and second derivatives.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(object_params)
READS(spheres)
READS(runs)
READS(entries)
READS(second_moments)
READS(layer_places)
READS(layer_firsts)
READS(layer_squares)
READS(layer_products)
WRITES(expansions)
#include "transport/diffusion/layers.glsl"
#include "transport/blocks/expand.glsl"

Expansion sum_of(uint block, uint first, uint last) {
    vec3 center = spheres[block].center;
    Expansion sum = NOTHING;
    for (uint k = first; k < last; ++k) {
        uint node = entries[k];
        Layers m = layers_of(node);
        vec3 x = center.x - m.x, y = center.y - m.y, z = center.z - m.z;
        Kernel kernel = kernel_at(x * x + y * y + z * z);
        sum.value += layers_at(m, second_moments[node], kernel, x, y, z);
        x *= kernel.by_s; y *= kernel.by_s; z *= kernel.by_s;
        vec3 along = m.ux * x + m.uy * y + m.uz * z;
        // Y d, d.Y.d and the trace.
        vec3 yx = m.xx * x + m.xy * y + m.zx * z, yy = m.xy * x + m.yy * y + m.yz * z, yz = m.zx * x + m.yz * y + m.zz * z;
        vec3 y_along = yx * x + yy * y + yz * z, trace = m.xx + m.yy + m.zz;
        // The gradient: of the charge, then of the first moment, then of the second.
        vec3 g1 = kernel.g * kernel.by_s, g2 = g1 * kernel.by_s, g3 = g2 * kernel.by_s;
        vec3 radial = -g1 * kernel.c1 * m.w - g2 * kernel.c2 * along + g3 * (kernel.c2 * trace - kernel.c3 * y_along);
        sum.x += radial * x + g2 * kernel.c1 * m.ux + 2.0 * g3 * kernel.c2 * yx;
        sum.y += radial * y + g2 * kernel.c1 * m.uy + 2.0 * g3 * kernel.c2 * yy;
        sum.z += radial * z + g2 * kernel.c1 * m.uz + 2.0 * g3 * kernel.c2 * yz;
        // The second derivatives: of the charge and of the first moment.
        vec3 even = -g2 * kernel.c1 * m.w - g3 * kernel.c2 * along;
        vec3 twice = g2 * kernel.c2 * m.w + g3 * kernel.c3 * along, mixed = -g3 * kernel.c2;
        sum.xx += even + x * (twice * x + 2.0 * mixed * m.ux);
        sum.yy += even + y * (twice * y + 2.0 * mixed * m.uy);
        sum.zz += even + z * (twice * z + 2.0 * mixed * m.uz);
        sum.yz += twice * y * z + mixed * (m.uy * z + m.uz * y);
        sum.zx += twice * z * x + mixed * (m.uz * x + m.ux * z);
        sum.xy += twice * x * y + mixed * (m.ux * y + m.uy * x);
    }
    return sum;
}

void main() {
    uint i = item();
    if (i >= range.count) return;
    Expansion sum = sum_of_runs(range.first + i, runs[i].first, runs[i].first + runs[i].expanded);
    if (LANES == 1 || gl_LocalInvocationIndex == 0) expansions[range.first + i] = sum;
}
