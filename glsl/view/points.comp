#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Receivers where the pixels of a tile show the object, and the sphere round them. One invocation a tile.
READS(frame)
READS(camera)
READS(hits)
READS(triangles)
READS(positions)
READS(clusters)
UPDATES(places)
WRITES(spheres)
#include "geometry/sphere.glsl"

const uint SIDE = 4, PLACES = 16;

void main() {
    uint tile = invocation();
    if (tile >= frame[0].blocks) return;
    uint width = camera[0].width, height = camera[0].height, across = (width + SIDE - 1) / SIDE;
    uvec2 corner = SIDE * uvec2(tile % across, tile / across);
    // The first place that shows the object serves those that do not.
    vec3 other = vec3(16.0);
    bool none = true;
    uint present = 0;
    for (uint k = 0; k < PLACES; ++k) {
        uvec2 at = corner + uvec2(k % SIDE, k / SIDE);
        bool inside = at.x < width && at.y < height;
        Hit hit = hits[inside ? at.y * width + at.x : 0];
        uint face = hit.face - frame[0].first_face;
        if (inside && face < frame[0].faces) {
            uvec3 c = triangles[face];
            vec3 place = (1.0 - hit.u - hit.v) * positions[c.x] + hit.u * positions[c.y] + hit.v * positions[c.z];
            other = none ? place : other;
            none = false;
            present |= 1u << k;
            places[PLACES * tile + k] = place;
        }
    }
    for (uint k = 0; k < PLACES; ++k) if ((present >> k & 1u) == 0) places[PLACES * tile + k] = other;
    spheres[tile] = sphere_of(PLACES * tile, PLACES);
}
