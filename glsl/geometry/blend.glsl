// What the corners of a triangle have, blended at a place on it. Macros, so that they serve every type, and are as precise
// as the variable that takes the result.

// The barycentric weights of the corners at a hit, or at what a texel shows.
#define CORNER_WEIGHTS(place) vec3(1.0 - (place).u - (place).v, (place).u, (place).v)
// Of three values.
#define BLEND(weight, a, b, c) ((weight).x * (a) + (weight).y * (b) + (weight).z * (c))
// Of a buffer's elements at the corners.
#define BLEND_AT(weight, values, corner) BLEND(weight, values[(corner).x], values[(corner).y], values[(corner).z])
