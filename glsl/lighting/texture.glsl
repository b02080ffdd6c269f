// The texture at one point: bilinear between the centres of four texels.

#include "lighting/wrap.glsl"

// The texture that has this first texel, size and wrap modes: (0, 0) is its upper left corner, (1, 1) its lower right.
vec3 texture_at(uint first, uvec2 size, uvec2 wrap, vec2 place) {
    vec2 at = vec2(size) * place - 0.5, low = floor(at), part = at - low;
    int column = int(low.x), row = int(low.y);
    uint left = wrapped(wrap.x, column, size.x), right = wrapped(wrap.x, column + 1, size.x);
    uint above = first + wrapped(wrap.y, row, size.y) * size.x, below = first + wrapped(wrap.y, row + 1, size.y) * size.x;
    return mix(mix(texels[above + left], texels[above + right], part.x),
               mix(texels[below + left], texels[below + right], part.x), part.y);
}

// The factors of an object's texture at a place.
vec3 texture_factor(uint object, vec2 place) {
    return texture_at(object_params[object].texture_first, object_params[object].texture_size, object_params[object].texture_wrap, place);
}
