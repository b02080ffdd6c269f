#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The first triangle that each pixel's ray hits.
READS(object_params)
READS(camera)
READS(placed_positions)
READS(triangles)
READS(placed_bounds)
WRITES(hits)
#include "geometry/trace.glsl"
#include "view/ray.glsl"

void main() {
    uint pixel = invocation();
    uint width = camera[0].width, height = camera[0].height;
    if (pixel >= width * height) return;

    precise float z = float(width) * float(height);
    Nearest nearest = trace(camera[0].origin, ray(pixel));

    float sum = nearest.weights.x + nearest.weights.y + nearest.weights.z;
    Hit hit = Hit(nearest.face, 0.0, 0.0, 0.0);
    if (nearest.face < UNFINISHED) {
        float depth = nearest.numerator / nearest.denominator * z;
        hit = Hit(nearest.face, nearest.weights.y / sum, nearest.weights.z / sum, depth);
    }
    hits[pixel] = hit;
}
