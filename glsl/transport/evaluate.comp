#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "dipole/profile.glsl"
#define NODES 12
#include "dipole/form_factor/edge.glsl"

// Single form factors at the origin: radial, displaced sources (Table 1, unclamped), and the profile at |a|.
READS(queries)
WRITES(answers)

float form(Query query, float sigma, vec3 normal, float height, vec3 h) {
    vec3 foot = -height * normal;
    vec3 j = edge_form(vec3(sigma), query.a, query.b, query.c, uvec3(0, 1, 2), normal, foot, h);
    return query.strength * (query.z_real * j.x + query.z_virtual * j.y);
}

void main() {
    uint i = invocation();
    if (i >= queries.length()) return;
    Query query = queries[i];
    vec3 normal = normalize(cross(query.b - query.a, query.c - query.a));
    float height = -dot((query.a + query.b + query.c) / 3.0, normal);
    float zr = query.z_real, zv = query.z_virtual;
    vec3 radial = sqrt(height * height + vec3(zr * zr, zv * zv, zv * zv));
    vec3 displaced = max(abs(vec3(height + zr, height - zv, height - zv)), 1e-12);
    vec3 s2 = dot(query.a, query.a) + vec3(zr * zr, zv * zv, zv * zv);
    vec3 p = dipole_kernel(vec3(query.sigma), s2);
    answers[i] = vec3(form(query, query.sigma, normal, height, radial),
                      form(query, query.sigma, normal, height, displaced),
                      query.strength * (zr * p.x + zv * p.y));
}
