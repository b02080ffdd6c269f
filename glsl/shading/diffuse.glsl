// Radiance of a pixel from the light, the normal and the curvature of the point that it shows: f(cos, sigma) times the
// light that arrives. The includer defines f as `respond`, its factors on the environment's harmonics as `respond_sky`,
// and the sigma of a point, from sigma_0 kappa, as `local_sigma`.
layout(constant_id = 0) const uint OBJECTS = 1;
layout(constant_id = 1) const uint SHADOWS = 0;
layout(constant_id = 2) const uint SKY = 0;
READS(camera)
READS(lights)
READS(lit)
READS(harmonics)
READS(triangles)
READS(placed_positions)
READS(packed_normals)
READS(hits)
UPDATES(radiance)
#include "geometry/blend.glsl"
#include "lighting/fresnel.glsl"
#include "lighting/harmonics.glsl"
#include "lighting/arrival.glsl"
#include "lighting/leaving.glsl"
#include "view/object.glsl"

// The normal of a vertex, of length 32767, and kappa, unpacked from what stage `pack_normals` writes.
vec4 bend(uint vertex) {
    uvec2 word = packed_normals[vertex];
    ivec3 normal = ivec3(word.x << 16, word.x, word.y << 16) >> 16;
    // The subtraction is exact here: a flat surface stays flat for any sigma_0.
    return vec4(vec3(normal), uintBitsToFloat((word.y >> 16 << 12) + floatBitsToUint(KAPPA_LEAST)) - KAPPA_LEAST);
}

void main() {
    // Values that all pixels share are read before any invocation returns: after that some drivers read them by lanes.
    // Without a sky there is at least one light, or nothing would be shaded.
    uint pixel = invocation(), count = object_params[0].lights;
    Camera view = camera[0];
    Light light;
    if (SKY == 0 || count > 0) light = lights[0];
    uint opaque = object_params[0].opaque;
    vec3 eta = object_params[0].eta, exits = object_params[0].exit, diffuse = object_params[0].diffuse, sigma_0 = object_params[0].sigma_0;
    float tilt = object_params[0].facet_tilt;
    if (pixel >= view.width * view.height) return;
    Hit hit = hits[pixel];
    if (hit.face >= UNFINISHED) {
        radiance[pixel] = view.background;
        return;
    }
    uint object = object_of(hit.face);
    if (OBJECTS != 1) {
        opaque = object_params[object].opaque;
        eta = object_params[object].eta;
        exits = object_params[object].exit;
        tilt = object_params[object].facet_tilt;
        diffuse = object_params[object].diffuse;
        sigma_0 = object_params[object].sigma_0;
    }
    if (opaque != OPAQUE_NOT) return;
    uvec3 corner = triangles[hit.face];
    vec3 weight = CORNER_WEIGHTS(hit);
    vec3 point = BLEND_AT(weight, placed_positions, corner);
    vec4 bent = BLEND(weight, bend(corner.x), bend(corner.y), bend(corner.z));
    vec3 normal = bent.xyz / sqrt(max(dot(bent.xyz, bent.xyz), 1e-30));
    vec3 sigma = local_sigma(sigma_0 * bent.w, object, hit.face, weight);

    vec3 sum = vec3(0), all = vec3(0), open = vec3(0);
    // The loop ends in its middle, before it reads a light beyond the last.
    uint i = 0;
    if (count > 0) for (;;) {
        vec3 toward;
        float arrives = arrival(light, point, toward), lets = reaches(light, hit.face);
        vec3 counts = respond(dot(normal, toward), sigma);
        if (light.kind != LIGHT_SKY_RAY) sum += light.color * (arrives * lets) * counts;
        if (SKY != 0) {
            if (light.kind == LIGHT_SKY_RAY) {
                vec3 part = sky_radiance(toward) * counts;
                all += part;
                open += lets * part;
            }
        }
        if (++i >= count) break;
        light = lights[i];
    }
    if (SKY != 0) {
        // The share is exactly 1 if no ray is blocked.
        mat3 zonal = respond_sky(sigma);
        vec3 whole = max(vec3(0), zonal[0] * degree_0() + zonal[1] * degree_1(normal) + zonal[2] * degree_2(normal));
        sum += whole * mix(open / max(all, vec3(1e-30)), vec3(1), equal(open, all));
    }
    vec3 eye = view.origin - point;
    float cosine = facet_cosine(SEEN_COSINE(normal, eye, corner), tilt);
    vec3 leaves = transmittance(eta, cosine) * exits;
    radiance[pixel] = leaves * diffuse * sum * (view.radiance / 3.14159265358979);
}
