// Light that near triangles deposit: a single layer, at its own depth in each channel. Decisions are exact.
#include "dipole/near.glsl"

// Whether a triangle's light is too near to a place for area points in some channel.
bool too_near(vec3 x, vec3 center, Deposit deposit, float area_distance) {
    precise vec3 red = center + deposit.red, green = center + deposit.green, blue = center + deposit.blue;
    precise float reach = max(area_distance, 0.0), reach2 = reach * reach;
    return distance2(x, red) < reach2 || distance2(x, green) < reach2 || distance2(x, blue) < reach2;
}
