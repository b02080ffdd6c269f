// The texture at one place: its texels, linear between the centres of four of them.

#include "light/wrap.glsl"

// Of an object's texture, which of `count` texels in a row stands at place i.
uint texel(uint object, int i, uint count) {
    return wrapped(frame[object].texture_wrap, i, count);
}

// Factors at a place: (0, 0) is the upper left corner of the texture, (1, 1) the lower right one.
vec3 texture_factor(uint object, vec2 place) {
    uvec2 size = frame[object].texture_size;
    vec2 at = vec2(size) * place - 0.5, low = floor(at), part = at - low;
    int column = int(low.x), row = int(low.y);
    uint first = frame[object].texture_first, left = texel(object, column, size.x), right = texel(object, column + 1, size.x);
    uint above = first + texel(object, row, size.y) * size.x, below = first + texel(object, row + 1, size.y) * size.x;
    return mix(mix(texels[above + left], texels[above + right], part.x),
               mix(texels[below + left], texels[below + right], part.x), part.y);
}

// Where a triangle has this place, by the weights of its second and third corner.
vec2 texture_place(CornerUvs uvs, vec2 weight) {
    return (1.0 - weight.x - weight.y) * uvs.a + weight.x * uvs.b + weight.y * uvs.c;
}
