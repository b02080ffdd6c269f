#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A vertex's radiosity: the area-weighted mean of the triangles around it. A triangle without area has no part in it,
// however bright: 0 times infinity is no number.
READS(object_params)
READS(corner_starts)
READS(corners)
READS(leaves)
READS(clusters)
READS(radiosity)
WRITES(vertex_radiosity)

float weight_of(uint face) { return clusters[leaves[face]].area; }

vec3 part_of(uint face, float weight) { return mix(vec3(0), weight * radiosity[face], bvec3(weight > 0.0)); }

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    vec3 sum = vec3(0);
    float area = 0.0;
    uint end = corner_starts[vertex + 1];
    // Four at once, so that their loads do not wait for each other.
    for (uint first = corner_starts[vertex]; first < end; first += 4) {
        uvec4 at = first + uvec4(0, 1, 2, 3), last = min(at, uvec4(end - 1));
        uvec4 face = uvec4(corners[last.x], corners[last.y], corners[last.z], corners[last.w]);
        vec4 weight = vec4(weight_of(face.x), weight_of(face.y), weight_of(face.z), weight_of(face.w));
        weight = mix(weight, vec4(0), greaterThan(at, last));
        sum = sum + part_of(face.x, weight.x) + part_of(face.y, weight.y) + part_of(face.z, weight.z) +
              part_of(face.w, weight.w);
        area = area + weight.x + weight.y + weight.z + weight.w;
    }
    vertex_radiosity[vertex] = area > 0.0 ? sum / area : vec3(0);
}
