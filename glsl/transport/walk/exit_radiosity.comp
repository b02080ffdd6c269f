#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A triangle's radiosity from the weights that left through it, and its standard error.
READS(object_params)
READS(leaves)
READS(clusters)
READS(walk_params)
READS(entry_blocks)
READS(exits)
WRITES(radiosity)
WRITES(walk_noise)
#include "transport/walk/entry_sums/factors.glsl"

vec3 wide_sum(uvec3 low, uvec3 high) { return vec3(high) * 4294967296.0 + vec3(low); }

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    EntryBlock total = entry_blocks[(object_params[0].faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK];
    ExitSum own = exits[face];
    float area = clusters[leaves[face]].area, photons_all = max(float(walk_params[0].photons), 1.0);
    float whole = float(WALK_WEIGHT), unit = whole / float(1u << WALK_SQUARE_BITS);

    // The light of a photon of full weight, and that per area; weights and their squares in units of full weight.
    vec3 light = wide_sum(total.low, total.high) / uintBitsToFloat(factors(total.most)) / photons_all;
    vec3 by_area = area > 0.0 ? light / area : vec3(0);
    vec3 left = wide_sum(own.once, own.once_high) / whole + wide_sum(own.more, own.more_high) / whole;
    vec3 squares = wide_sum(own.square, own.square_high) / (unit * unit);
    radiosity[face] = by_area * left;
    walk_noise[face] = by_area * sqrt(max(squares - left * left / photons_all, vec3(0)));
}
