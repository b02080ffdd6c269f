// Interpolation between the corners of a triangle. Macros, so that they serve every type, and are `precise` if the
// variable that takes the result is.

// The barycentric weights of the corners at a `Hit` or a `TexelHit`.
#define CORNER_WEIGHTS(place) vec3(1.0 - (place).u - (place).v, (place).u, (place).v)
// Between three values.
#define BLEND(weight, a, b, c) ((weight).x * (a) + (weight).y * (b) + (weight).z * (c))
// Between a buffer's elements at the corners.
#define BLEND_AT(weight, values, corner) BLEND(weight, values[(corner).x], values[(corner).y], values[(corner).z])
