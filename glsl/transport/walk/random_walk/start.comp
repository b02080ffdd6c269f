#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Each slot without a photon under way starts its next one, if there is one left: at a triangle drawn by the light that
// enters it, at a place drawn evenly.
layout(constant_id = 0) const uint SHADOWS = 0;
layout(constant_id = 1) const uint SKY = 0;
READS(object_params)
READS(lights)
READS(leaves)
READS(clusters)
READS(triangles)
READS(positions)
READS(lit)
READS(irradiance)
READS(walk_params)
READS(entry_sums)
READS(entry_blocks)
UPDATES(photons)
UPDATES(balances)
#include "geometry/sight.glsl"
#include "geometry/turn.glsl"
#include "geometry/placed.glsl"
#include "transport/walk/exact.glsl"
#include "transport/walk/entering.glsl"

// The triangle at this share of the light that enters, `place` / 2^32.
uint drawn(uint channel, uint place) {
    uint faces = object_params[0].faces, all = (faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK;
    EntryBlock total = entry_blocks[all];
    uint low_of_low, high_of_low, low_of_high, high, carry;
    umulExtended(total.low[channel], place, high_of_low, low_of_low);
    umulExtended(total.high[channel], place, high, low_of_high);
    uint low = uaddCarry(low_of_high, high_of_low, carry);
    high += carry;
    uint before = 0;
    for (uint step = 1u << findMSB(faces); step > 0; step >>= 1) {
        uint next = before + step, at = min(next, faces) - 1;
        uint sum_high = entry_sums[at].high[channel], sum_low = entry_sums[at].low[channel];
        bool below = sum_high < high || (sum_high == high && sum_low <= low);
        if (next <= faces && below) before = next;
    }
    return min(before, faces - 1);
}

void main() {
    uint slot = invocation();
    if (slot >= walk_params[0].slots) return;
    Photon photon = photons[slot];
    uint channel = slot % 3, every = walk_params[0].slots / 3;
    uint number = slot / 3 + photon.started * every;
    uint all = (object_params[0].faces + ENTRY_BLOCK - 1) / ENTRY_BLOCK;
    bool light = (entry_blocks[all].low[channel] | entry_blocks[all].high[channel]) != 0;
    if (photon.weight != 0 || number >= walk_params[0].photons || !light) return;
    uvec4 random = random4(number, 0, channel, walk_params[0].seed);
    uint face = drawn(channel, random.x);
    uvec3 corner = triangles[face];
    vec3 a = positions[corner.x];
    precise vec3 b = positions[corner.y] - a;
    precise vec3 c = positions[corner.z] - a;
    precise vec3 large = FAR_FROM_DENORMAL * cross3(b, c);
    vec3 normal = unit_of(large);

    // Drawn evenly over the parallelogram, whose other half is folded back.
    float u = unit_random(random.y), v = unit_random(random.z);
    precise float both = u + v;
    bool fold = both > 1.0;
    precise float across = fold ? 1.0 - u : u;
    precise float up = fold ? 1.0 - v : v;
    precise vec3 place = a + (across * b + up * c);
    vec3 way = entry(channel, face, clusters[leaves[face]].center, normal, number, random);
    photons[slot] = Photon(place, way, WALK_WEIGHT, face, number, 0, 0, photon.started + 1);
    uvec2 entered = balances[slot].entered;
    uint low = entered.x + WALK_WEIGHT;
    balances[slot].entered = uvec2(low, entered.y + uint(low < WALK_WEIGHT));
}
