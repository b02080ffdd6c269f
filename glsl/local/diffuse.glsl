// Radiance of a pixel by the light, the normal and the curvature of the place that it shows: f(cos, sigma), which has to be
// defined as `respond` before, times what arrives. `bend` is the normal of a vertex and its kappa, `spread` the sigma that
// follows; f's factors on the environment's harmonics are `respond_sky`.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(constant_id = 1) const uint SHADOWS = 0;
layout(constant_id = 2) const uint SKY = 0;
READS(camera)
READS(lights)
READS(lit)
READS(harmonics)
READS(triangles)
READS(positions)
READS(hits)
UPDATES(radiance)
#include "light/fresnel.glsl"
#include "light/harmonics.glsl"
#include "light/arrival.glsl"
#include "view/object.glsl"

void main() {
    uint pixel = invocation();
    if (pixel >= camera[0].width * camera[0].height) return;
    Hit hit = hits[pixel];
    if (hit.face >= MISSED) {
        radiance[pixel] = camera[0].background;
        return;
    }
    uint object = object_of(hit.face);
    if (frame[object].opaque != 0) return;
    uvec3 corner = triangles[hit.face];
    vec3 weight = vec3(1.0 - hit.u - hit.v, hit.u, hit.v);
    vec3 point = weight.x * positions[corner.x] + weight.y * positions[corner.y] + weight.z * positions[corner.z];
    vec4 bent = weight.x * bend(corner.x) + weight.y * bend(corner.y) + weight.z * bend(corner.z);
    vec3 normal = bent.xyz / sqrt(max(dot(bent.xyz, bent.xyz), 1e-30));
    vec3 sigma = spread(object, hit.face, weight, bent.w);

    vec3 sum = vec3(0), all = vec3(0), open = vec3(0);
    // The loop is left at its end: where it is left at its head some drivers run the body once more, for nobody.
    uint i = 0;
    if (frame[0].lights > 0) do {
        Light light = lights[i];
        vec3 toward;
        float arrives = arrival(light, point, toward), lets = reaches(light, hit.face);
        vec3 counts = respond(dot(normal, toward), sigma);
        if (light.kind != 5) sum += light.color * (arrives * lets) * counts;
        if (SKY != 0) {
            if (light.kind == 5) {
                vec3 part = sky_radiance(toward) * counts;
                all += part;
                open += lets * part;
            }
        }
    } while (++i < frame[0].lights);
    if (SKY != 0) {
        // Where no ray is blocked the share is 1 to the last bit.
        mat3 zonal = respond_sky(sigma);
        vec3 whole = max(vec3(0), zonal[0] * degree_0() + zonal[1] * degree_1(normal) + zonal[2] * degree_2(normal));
        sum += whole * mix(open / max(all, vec3(1e-30)), vec3(1), equal(open, all));
    }
    vec3 eye = camera[0].origin - point;
    float cosine = abs(dot(normal, eye)) / sqrt(max(dot(eye, eye), 1e-30));
    vec3 leaves = transmittance(frame[object].eta, cosine) * frame[object].exit;
    radiance[pixel] = leaves * frame[object].diffuse * sum * (camera[0].radiance / 3.14159265358979);
}
