#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "dipole/profile.glsl"
#include "geometry/area.glsl"
#define NODES 12
#include "dipole/form_factor/edge.glsl"

// Single form factors at the origin: with radial sources, and with displaced ones (Table 1, unclamped); and the profile
// at |a|.
READS(queries)
WRITES(answers)

// chi (form_factor/ladder.rs) below which one sample with its second moment serves. It is within about 2 chi^2 of the
// exact value, while the edge integrals of such a distant triangle cancel completely, even in sign.
const float FAR = 1e-3;

float form(Query query, float sigma, vec3 area, vec3 normal, float height, vec3 h) {
    vec3 foot = -height * normal;
    vec3 j = edge_form(vec3(sigma), query.a, query.b, query.c, uvec3(0, 1, 2), normal, foot, h);

    vec3 center = (query.a + query.b + query.c) / 3.0;
    vec3 e0 = query.b - query.a, e1 = query.c - query.b, e2 = query.a - query.c;
    float tau = (dot(e0, e0) + dot(e1, e1) + dot(e2, e2)) / 36.0;
    vec3 dots = vec3(dot(e0, center), dot(e1, center), dot(e2, center));
    vec3 s2 = max(vec3(0), dot(center, center) - height * height) + h * h;
    vec3 a = sigma * sqrt(s2);
    vec3 chi = 0.5 * tau / s2 * (15.0 + a * (15.0 + a * (6.0 + a))) / (1.0 + a);
    vec3 one = length(area) * dipole_kernel(vec3(sigma), s2)
             * moment_correction(vec3(sigma), s2, tau, dot(dots, dots) / 36.0);
    j = mix(j, one, lessThan(chi, vec3(FAR)));
    return query.strength * (query.z_real * j.x + query.z_virtual * j.y);
}

void main() {
    uint i = invocation();
    if (i >= queries.length()) return;
    Query query = queries[i];
    // A triangle that has no area in single precision has no normal either, and its form factor is 0.
    vec3 area = vector_area(query.a, query.b, query.c);
    vec3 size = abs(area);
    float largest = max(size.x, max(size.y, size.z));
    vec3 normal = largest > 0.0 ? normalize(area / largest) : vec3(0);
    float height = -dot((query.a + query.b + query.c) / 3.0, normal);
    float zr = query.z_real, zv = query.z_virtual;
    vec3 radial = sqrt(height * height + vec3(zr * zr, zv * zv, zv * zv));
    vec3 displaced = max(abs(vec3(height + zr, height - zv, height - zv)), 1e-12);
    vec3 s2 = dot(query.a, query.a) + vec3(zr * zr, zv * zv, zv * zv);
    vec3 p = dipole_kernel(vec3(query.sigma), s2);
    answers[i] = vec3(form(query, query.sigma, area, normal, height, radial),
                      form(query, query.sigma, area, normal, height, displaced),
                      query.strength * (zr * p.x + zv * p.y));
}
