#include "geometry/blend.glsl"

// The point where a ray hits the object, as the eye sees it.
struct Surface {
    vec3 point;
    vec3 normal; // interpolated, on the side of the triangle that is seen
    vec3 toward; // unit direction to the eye
};

Surface surface(Hit hit) {
    uvec3 corner = triangles[hit.face];
    vec3 weight = CORNER_WEIGHTS(hit);
    vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
    vec3 point = BLEND(weight, a, b, c);
    vec3 normal = BLEND_AT(weight, placed_normals, corner);
    vec3 toward = camera[0].origin - point;
    float side = dot(cross(b - a, c - a), toward) < 0.0 ? -1.0 : 1.0;
    return Surface(point, unit(normal) * side, unit(toward));
}
