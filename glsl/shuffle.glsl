// Values of a neighbour in the subgroup. Without shuffles each invocation has itself as its only neighbour.
layout(constant_id = SHUFFLE_ID) const uint SHUFFLES = 1;

// How many invocations of a block share what they load: a power of two.
uint sharing() { return SHUFFLES != 0 ? min(gl_SubgroupSize, BLOCK_RECEIVERS) : 1; }

float shuffled(float v, uint from) { return SHUFFLES != 0 ? subgroupShuffle(v, from) : v; }
vec3 shuffled(vec3 v, uint from) { return vec3(shuffled(v.x, from), shuffled(v.y, from), shuffled(v.z, from)); }
