#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The triangle that each pixel's ray meets first.
READS(frame)
READS(camera)
READS(positions)
READS(triangles)
READS(topology)
READS(bounds)
WRITES(hits)
#include "geometry/trace.glsl"

void main() {
    uint pixel = invocation();
    uint width = camera[0].width, height = camera[0].height;
    if (pixel >= width * height) return;

    // Through the pixel's centre; the scale of the ray is free, so nothing is divided.
    uint column = pixel % width, row = pixel / width;
    float w = float(width), h = float(height);
    precise float x = (float(2 * column + 1) - w) * h;
    precise float y = (h - float(2 * row + 1)) * w;
    precise float z = w * h;
    precise vec3 direction = z * camera[0].forward + x * camera[0].right + y * camera[0].up;
    Nearest nearest = trace(camera[0].origin, direction);

    float sum = nearest.weights.x + nearest.weights.y + nearest.weights.z;
    Hit hit = Hit(nearest.face, 0.0, 0.0, 0.0);
    if (nearest.face < frame[0].faces) {
        float depth = nearest.numerator / nearest.denominator * z;
        hit = Hit(nearest.face, nearest.weights.y / sum, nearest.weights.z / sum, depth);
    }
    hits[pixel] = hit;
}
