#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"
#include "light/fresnel.glsl"

// E of equation 5 at a face's centroid: every light's cosine times Fresnel transmittance, unshadowed.
READS(frame)
READS(lights)
READS(leaves)
READS(clusters)
WRITES(irradiance)

void main() {
    uint face = invocation();
    if (face >= frame[0].faces) return;
    Cluster leaf = clusters[leaves[face]];
    vec3 normal = leaf.area > 0.0 ? leaf.normal / leaf.area : vec3(0);
    vec3 sum = vec3(0);
    for (uint i = 0; i < frame[0].lights; ++i) {
        Light light = lights[i];
        vec3 toward = light.place;
        float falloff = 1.0;
        if (light.kind == 1) {
            toward -= leaf.center;
            float d2 = max(dot(toward, toward), 1e-30);
            falloff = 1.0 / d2;
            toward /= sqrt(d2);
        }
        float cosine = dot(normal, toward);
        sum += light.color * (max(cosine, 0.0) * falloff) * transmittance(frame[0].eta, cosine);
    }
    irradiance[face] = sum;
}
