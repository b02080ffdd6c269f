#include "geometry/blend.glsl"

// Which of `count` texels in a row stands at place i, by a WRAP_ mode; i is at least -count, or -2 count if mirrored.
uint wrapped(uint wrap, int i, uint count) {
    if (wrap == WRAP_CLAMP) return uint(clamp(i, 0, int(count) - 1));
    uint period = wrap == WRAP_MIRROR ? 2 * count : count;
    uint k = uint(max(i + int(period), 0)) % period;
    return k < count ? k : period - 1 - k;
}

// Texture coordinates of a point of a triangle, by the weights of its second and third corner.
vec2 texture_place(CornerUvs uvs, vec2 weight) {
    return BLEND(vec3(1.0 - weight.x - weight.y, weight), uvs.a, uvs.b, uvs.c);
}
