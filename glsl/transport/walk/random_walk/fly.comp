#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A few flights of each photon under way: free ones, to a collision far from the surface; then one that may meet the
// surface, where the photon leaves or is reflected.
READS(object_params)
READS(triangles)
READS(positions)
READS(bounds)
READS(walk_params)
READS(clearance)
UPDATES(photons)
UPDATES(balances)
UPDATES(exits)
#include "geometry/sight.glsl"
#include "geometry/turn.glsl"
#include "transport/walk/exact.glsl"
#include "transport/walk/hit.glsl"

uvec2 added(uvec2 sum, uint more) {
    uint low = sum.x + more;
    return uvec2(low, sum.y + uint(low < more));
}

// Adds a photon that leaves through a triangle.
void leave(uint face, uint channel, uint weight, bool once) {
    uint root = weight >> WALK_SQUARE_BITS, square = root * root;
    uint before = atomicAdd(exits[face].square[channel], square);
    if (before + square < before) atomicAdd(exits[face].square_high[channel], 1u);
    if (once) {
        before = atomicAdd(exits[face].once[channel], weight);
        if (before + weight < before) atomicAdd(exits[face].once_high[channel], 1u);
    } else {
        before = atomicAdd(exits[face].more[channel], weight);
        if (before + weight < before) atomicAdd(exits[face].more_high[channel], 1u);
    }
}

// The direction after a collision.
vec3 scattered(vec3 way, float forward, uvec4 random) {
    float u = unit_random(random.z);
    precise float even = 2.0 * u - 1.0;
    precise float g2 = forward * forward;
    precise float part = (1.0 - g2) * inverse_of(1.0 - forward + 2.0 * forward * u);
    precise float leaning = (1.0 + g2 - part * part) * (0.5 * inverse_of(max(abs(forward), 1e-6)));
    float cosine = forward == 0.0 ? even : clamp(forward < 0.0 ? -leaning : leaning, -1.0, 1.0);
    return kept_unit(about(way, cosine, unit_random(random.w)));
}

// A lower bound on the distance of the surface from a place in the object.
float around(vec3 place) {
    vec3 low = bounds[0].low, high = bounds[0].high;
    precise vec3 size = max(high - low, vec3(1e-20));
    precise vec3 apart = max(place - low, vec3(0));
    vec3 by = vec3(inverse_of(size.x), inverse_of(size.y), inverse_of(size.z));
    precise vec3 cells = apart * (float(CLEARANCE_SIDE) * by);
    uvec3 at = uvec3(min(cells, vec3(CLEARANCE_SIDE - 1)));
    return clearance[at.x + CLEARANCE_SIDE * (at.y + CLEARANCE_SIDE * at.z)];
}

// A collision at the end of a flight.
void collide(inout Photon photon, inout WalkBalance balance, float path, uint channel, uvec4 random) {
    precise vec3 place = photon.place + path * photon.way;
    photon.place = place;
    uint absorbed, rest;
    umulExtended(photon.weight, walk_params[0].absorbed[channel], absorbed, rest);
    uint weight = photon.weight - absorbed;
    balance.absorbed = added(balance.absorbed, absorbed);
    if (weight < WALK_LIGHT) {
        bool dies = (random.y & 0x80000000u) != 0;
        if (dies) balance.killed = added(balance.killed, weight);
        else balance.gained = added(balance.gained, weight);
        weight = dies ? 0 : 2 * weight;
    }
    photon.weight = weight;
    photon.way = scattered(photon.way, walk_params[0].forward[channel], random);
    photon.collisions = min(photon.collisions + 1, 2);
    photon.face = NONE;
}

// The next flight's random numbers and length.
uvec4 drawn(inout Photon photon, uint channel, out float path) {
    photon.flights++;
    uvec4 random = random4(photon.number, photon.flights, channel, walk_params[0].seed);
    precise float apart = minus_log(unit_random(random.x)) * walk_params[0].free_path[channel];
    path = apart;
    return random;
}

void main() {
    uint slot = invocation();
    if (slot >= walk_params[0].slots) return;
    Photon photon = photons[slot];
    if (photon.weight == 0) return;
    WalkBalance balance = balances[slot];
    uint channel = slot % 3;
    float path;
    uvec4 random = drawn(photon, channel, path);
    bool free = path < around(photon.place);
    for (uint k = 0; k < WALK_FREE; ++k) {
        if (free) {
            collide(photon, balance, path, channel, random);
            if (photon.weight != 0) random = drawn(photon, channel, path);
            free = photon.weight != 0 && path < around(photon.place);
        }
    }
    if (photon.weight != 0) {
        vec3 weights;
        uint face = meeting(photon.place, photon.way, path, photon.face, weights);
        if (face == NONE) {
            collide(photon, balance, path, channel, random);
        } else if (face == UNFINISHED) {
            balance.lost = added(balance.lost, photon.weight);
            photon.weight = 0;
        } else {
            uvec3 corner = triangles[face];
            vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
            vec3 w = abs(weights);
            precise float sum = w.x + w.y + w.z;
            precise vec3 share = w * inverse_of(sum);
            precise vec3 place = share.x * a + share.y * b + share.z * c;
            photon.place = place;
            precise vec3 right = b - a;
            precise vec3 up = c - a;
            precise vec3 large = FAR_FROM_DENORMAL * cross3(right, up);
            vec3 normal = unit_of(large);
            float eta = object_params[0].eta[channel], inner = clamp(dot3(photon.way, normal), 0.0, 1.0);
            if (unit_random(random.y) < passes(eta, outside_of(eta, inner), inner)) {
                if (photon.collisions == 0) balance.straight = added(balance.straight, photon.weight);
                else leave(face, channel, photon.weight, photon.collisions == 1);
                photon.weight = 0;
            } else {
                precise vec3 way = photon.way - 2.0 * inner * normal;
                photon.way = kept_unit(way);
                photon.face = face;
            }
        }
    }
    if (photon.weight != 0 && photon.flights >= WALK_FLIGHTS) {
        balance.lost = added(balance.lost, photon.weight);
        photon.weight = 0;
    }
    photons[slot] = photon;
    balances[slot] = balance;
}
