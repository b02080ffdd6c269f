// An invocation's place in its group, and values of its neighbours in the subgroup. Subgroups are full, so that lanes
// are numbered by them. With WITHOUT_SUBGROUPS there is no subgroup operation: each invocation is alone. build.rs
// compiles each kernel that includes this file both ways; devices that do not grant full subgroups get that one.
#ifdef WITHOUT_SUBGROUPS
const uint SUBGROUP_SIZE = 1, SUBGROUP_LANE = 0;

// The place in the group.
uint lane() { return gl_LocalInvocationIndex; }

float shuffled(float v, uint from) { return v; }
uint shuffled(uint v, uint from) { return v; }

// Makes the subgroup's writes to shared memory visible to all of its invocations.
void exchange_in_subgroup() {}
#else
#define SUBGROUP_SIZE gl_SubgroupSize
#define SUBGROUP_LANE gl_SubgroupInvocationID

uint lane() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }

float shuffled(float v, uint from) { return subgroupShuffle(v, from); }
uint shuffled(uint v, uint from) { return subgroupShuffle(v, from); }

layout(constant_id = LOCKSTEP_ID) const uint LOCKSTEP = 0;

void exchange_in_subgroup() {
    subgroupMemoryBarrierShared();
    if (LOCKSTEP == 0) subgroupBarrier();
}
#endif

vec3 shuffled(vec3 v, uint from) { return vec3(shuffled(v.x, from), shuffled(v.y, from), shuffled(v.z, from)); }

// How many invocations of a block share what they load: a power of two.
uint sharing() { return min(SUBGROUP_SIZE, BLOCK_RECEIVERS); }
