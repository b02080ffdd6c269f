#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Receivers where the pixels of a tile show the object, divided into blocks of nearby ones. One invocation a tile. All
// but the spheres are decisions. Unrolled, the loops are so long that lavapipe's compiler takes over a second.
READS(object_params)
READS(camera)
READS(hits)
READS(triangles)
READS(positions)
READS(clusters)
UPDATES(receiver_positions)
UPDATES(seen)
WRITES(blocks)
WRITES(spheres)
#include "geometry/blend.glsl"
#include "geometry/sphere.glsl"

float square(vec3 v) {
    precise float sum = v.x * v.x + v.y * v.y + v.z * v.z;
    return sum;
}

void main() {
    uint tile = invocation();
    if (tile >= object_params[0].blocks / TILE_BLOCKS) return;
    uint width = camera[0].width, height = camera[0].height, across = (width + TILE_SIDE - 1) / TILE_SIDE;
    uvec2 corner = TILE_SIDE * uvec2(tile % across, tile / across);
    float pixels = float(width), right = square(camera[0].right);

    // The layer of each place: the first whose seed is near, or a new one; TILE_BLOCKS where the place shows nothing.
    vec3 found[BLOCK_RECEIVERS];
    uint layer_of[BLOCK_RECEIVERS];
    vec3 seeds[TILE_BLOCKS] = vec3[TILE_BLOCKS](vec3(NOWHERE), vec3(NOWHERE), vec3(NOWHERE), vec3(NOWHERE));
    uint seeded = 0;
    bool torn = false;
    [[dont_unroll]] for (uint k = 0; k < BLOCK_RECEIVERS; ++k) {
        uvec2 at = corner + uvec2(k % TILE_SIDE, k / TILE_SIDE);
        bool inside = at.x < width && at.y < height;
        Hit hit = hits[inside ? at.y * width + at.x : 0];
        uint face = hit.face - object_params[0].first_face;
        bool shown = inside && face < object_params[0].faces;
        uvec3 c = triangles[shown ? face : 0];
        precise vec3 weight = CORNER_WEIGHTS(hit);
        precise vec3 place = BLEND_AT(weight, positions, c);
        precise float widest = TILE_REACH * (right * (hit.depth * hit.depth));
        uint layer = TILE_BLOCKS;
        for (uint j = 0; j < TILE_BLOCKS; ++j) {
            precise vec3 offset = place - seeds[j];
            precise float distance2 = square(offset) * (pixels * pixels);
            bool near = j < seeded && distance2 <= widest;
            layer = layer == TILE_BLOCKS && (near || j == seeded) ? j : layer;
        }
        if (shown && layer == TILE_BLOCKS) {
            torn = true;
            layer = TILE_BLOCKS - 1;
        }
        if (shown && layer == seeded) {
            seeds[layer] = place;
            seeded += 1;
        }
        found[k] = place;
        layer_of[k] = shown ? layer : TILE_BLOCKS;
    }

    // Layer by layer.
    uint next = BLOCK_RECEIVERS * tile;
    [[dont_unroll]] for (uint layer = 0; layer < TILE_BLOCKS; ++layer) {
        uint first = next;
        [[dont_unroll]] for (uint k = 0; k < BLOCK_RECEIVERS; ++k) {
            if (layer_of[k] == layer) {
                uvec2 at = corner + uvec2(k % TILE_SIDE, k / TILE_SIDE);
                receiver_positions[next] = found[k];
                seen[at.y * width + at.x] = next;
                next += 1;
            }
        }
        uint count = next - first;
        Sphere sphere = sphere_of(first, count);
        if (count == 0) sphere = Sphere(vec3(NOWHERE), 0.0, 0.0);
        if (torn && layer == TILE_BLOCKS - 1) sphere.relative_moment = UNBOUNDED_SPREAD;
        blocks[TILE_BLOCKS * tile + layer] = Block(0, first, count);
        spheres[TILE_BLOCKS * tile + layer] = sphere;
    }
    [[dont_unroll]] for (uint k = 0; k < BLOCK_RECEIVERS; ++k) {
        if (BLOCK_RECEIVERS * tile + k >= next) receiver_positions[BLOCK_RECEIVERS * tile + k] = vec3(NOWHERE);
    }
}
