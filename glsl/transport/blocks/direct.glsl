// The emitters of a block's list for direct evaluation, summed at each of its receivers. Neighbouring invocations that
// share a block load one emitter each, and shuffle them. Each run of DIRECT_RUN emitters is summed by itself, then
// these sums are, in their order: so runs may be summed at once.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = TEAMS_ID) const uint TEAMS = 1; // invocations that share a receiver: 1, or the group has one block
#include "transport/blocks/gather/receiver.glsl"

const uint DIRECT_RUN = 16; // emitters that are summed by themselves
const uint DIRECT_RUNS = 8; // such runs that a group sums at once

// The sums of one receiver: of light, and with ESTIMATE of its error.
vec3 sum, error;

// Adds as many emitters of the list as are loaded at once, from number `at` on: the includer's.
void add_some(vec3 x, uint first, uint at, uint count, uint width);

shared vec3 sums[DIRECT_RUNS * BLOCK_RECEIVERS], errors[DIRECT_RUNS * BLOCK_RECEIVERS];

// The sums of this invocation's receiver; false if there is none, or another invocation has them.
bool sum_of_runs(out Receiver self, out vec3 all, out vec3 all_errors) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint slot = lane() % BLOCK_RECEIVERS, team = lane() / BLOCK_RECEIVERS, width = sharing();
    self = receiver_at(TEAMS == 1 ? group * gl_WorkGroupSize.x + lane() : group * BLOCK_RECEIVERS + slot);
    Runs run = runs[self.run];
    uint first = run.first + run.expanded, count = run.direct;
    all = vec3(0);
    all_errors = vec3(0);
    sum = vec3(0);
    error = vec3(0);
    if (TEAMS == 1) {
        for (uint at = 0; at < count; at += width) {
            add_some(self.x, first, at, count, width);
            if ((at + width) % DIRECT_RUN == 0 || at + width >= count) {
                all += sum;
                all_errors += error;
                sum = vec3(0);
                error = vec3(0);
            }
        }
        return self.present;
    }
    // The group has one block, so that all its invocations reach each barrier.
    for (uint begin = 0; begin < count; begin += DIRECT_RUNS * DIRECT_RUN) {
        for (uint k = team; k < DIRECT_RUNS; k += TEAMS) {
            uint from = begin + k * DIRECT_RUN, to = min(from + DIRECT_RUN, count);
            sum = vec3(0);
            error = vec3(0);
            for (uint at = from; at < to; at += width) add_some(self.x, first, at, to, width);
            sums[k * BLOCK_RECEIVERS + slot] = sum;
            if (ESTIMATE != 0) errors[k * BLOCK_RECEIVERS + slot] = error;
        }
        barrier();
        for (uint k = 0; k < DIRECT_RUNS && begin + k * DIRECT_RUN < count; ++k) {
            all += sums[k * BLOCK_RECEIVERS + slot];
            if (ESTIMATE != 0) all_errors += errors[k * BLOCK_RECEIVERS + slot];
        }
        barrier();
    }
    return team == 0 && self.present;
}
