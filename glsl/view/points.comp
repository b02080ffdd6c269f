#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Receivers where the pixels of a tile show the object, parted into blocks of what is near each other. One invocation a
// tile. Decisions only, but for the spheres.
READS(frame)
READS(camera)
READS(hits)
READS(triangles)
READS(positions)
READS(clusters)
UPDATES(places)
UPDATES(seen)
WRITES(blocks)
WRITES(spheres)
#include "geometry/sphere.glsl"

const uint SIDE = 4, PLACES = 16, LAYERS = 4;
const vec3 NOWHERE = vec3(16.0);

float square(vec3 v) {
    precise float sum = v.x * v.x + v.y * v.y + v.z * v.z;
    return sum;
}

void main() {
    uint tile = invocation();
    if (tile >= frame[0].blocks / LAYERS) return;
    uint width = camera[0].width, height = camera[0].height, across = (width + SIDE - 1) / SIDE;
    uvec2 corner = SIDE * uvec2(tile % across, tile / across);
    float pixels = float(width), right = square(camera[0].right);

    // The layer of each place: the first whose seed is near, or a new one; LAYERS where the place shows nothing.
    vec3 found[PLACES];
    uint layer_of[PLACES];
    vec3 seeds[LAYERS] = vec3[LAYERS](NOWHERE, NOWHERE, NOWHERE, NOWHERE);
    uint seeded = 0;
    bool torn = false;
    for (uint k = 0; k < PLACES; ++k) {
        uvec2 at = corner + uvec2(k % SIDE, k / SIDE);
        bool inside = at.x < width && at.y < height;
        Hit hit = hits[inside ? at.y * width + at.x : 0];
        uint face = hit.face - frame[0].first_face;
        bool shown = inside && face < frame[0].faces;
        uvec3 c = triangles[shown ? face : 0];
        precise float weight = 1.0 - hit.u - hit.v;
        precise vec3 place = weight * positions[c.x] + hit.u * positions[c.y] + hit.v * positions[c.z];
        precise float widest = 1024.0 * (right * (hit.depth * hit.depth));
        uint layer = LAYERS;
        for (uint j = 0; j < LAYERS; ++j) {
            precise vec3 offset = place - seeds[j];
            precise float distance2 = square(offset) * (pixels * pixels);
            bool near = j < seeded && distance2 <= widest;
            layer = layer == LAYERS && (near || j == seeded) ? j : layer;
        }
        if (shown && layer == LAYERS) {
            torn = true;
            layer = LAYERS - 1;
        }
        if (shown && layer == seeded) {
            seeds[layer] = place;
            seeded += 1;
        }
        found[k] = place;
        layer_of[k] = shown ? layer : LAYERS;
    }

    // Layer by layer.
    uint next = PLACES * tile;
    for (uint layer = 0; layer < LAYERS; ++layer) {
        uint first = next;
        for (uint k = 0; k < PLACES; ++k) {
            if (layer_of[k] == layer) {
                uvec2 at = corner + uvec2(k % SIDE, k / SIDE);
                places[next] = found[k];
                seen[at.y * width + at.x] = next;
                next += 1;
            }
        }
        uint count = next - first;
        Sphere sphere = sphere_of(first, count);
        if (count == 0) sphere = Sphere(NOWHERE, 0.0, 0.0);
        if (torn && layer == LAYERS - 1) sphere.spread = 1e30;
        blocks[LAYERS * tile + layer] = Block(0, first, count);
        spheres[LAYERS * tile + layer] = sphere;
    }
    for (uint k = 0; k < PLACES; ++k) if (PLACES * tile + k >= next) places[PLACES * tile + k] = NOWHERE;
}
