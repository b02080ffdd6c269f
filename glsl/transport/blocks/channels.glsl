// Repeats a piece of code for each channel `c` of the group: the bits of the specialization constant CHANNELS.
#define EACH_CHANNEL(code) \
    if ((CHANNELS & 1u) != 0) { const uint c = 0; code } \
    if ((CHANNELS & 2u) != 0) { const uint c = 1; code } \
    if ((CHANNELS & 4u) != 0) { const uint c = 2; code }

// The group's channels of `new`, the others of `old`.
vec3 only_group(vec3 new, vec3 old) {
    return vec3((CHANNELS & 1u) != 0 ? new.x : old.x, (CHANNELS & 2u) != 0 ? new.y : old.y,
                (CHANNELS & 4u) != 0 ? new.z : old.z);
}
