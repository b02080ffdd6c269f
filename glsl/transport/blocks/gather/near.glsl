// A block's near triangles at each of its receivers. Each run of NEAR_RUN triangles is summed by itself, then these
// sums are, in their order: so teams of invocations may sum runs at once. The includer reads the buffers named here,
// and says whether it has ERRORS; with ALONE it has no teams, with NO_SUMS it sums nothing here.
#ifndef NEAR_RUN
#define NEAR_RUN 4
#endif
#ifdef ALONE
layout(local_size_x = GROUP_SIZE) in;
const uint TEAMS = 1;
#else
layout(local_size_x = GROUP_SIZE, local_size_x_id = COUNTED_ID) in;
layout(constant_id = TEAMS_ID) const uint TEAMS = 1; // invocations that share a receiver: 1, or the group has one block
#endif

// The receiver of this invocation, its block's lists, and that block's place among those that have near triangles.
Receiver near_receiver(out Runs run, out uint slot) {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, blocks_near = near_groups[2].x;
    uint place = gl_LocalInvocationIndex, run_near = group * (GROUP_SIZE / BLOCK_RECEIVERS) + place / BLOCK_RECEIVERS;
    if (TEAMS > 1) run_near = group;
    slot = min(run_near, blocks_near - 1);
    Receiver self = receiver_of(near[slot], place, run_near < blocks_near);
    run = runs[self.run];
    return self;
}

Receiver near_receiver(out Runs run) {
    uint slot;
    return near_receiver(run, slot);
}

// This invocation's team.
uint team() { return TEAMS == 1 ? 0 : gl_LocalInvocationIndex / BLOCK_RECEIVERS; }

// Whether this invocation stores its receiver's sums.
bool stores(Receiver self) { return self.present && team() == 0; }

#ifndef NO_SUMS
// The includer adds number `k` of the list to `sum` and `error`.
void add(uint k);

vec3 sum = vec3(0), error = vec3(0);
shared vec3 sums[MOST_LANES], errors[MOST_LANES];

// The sums of the triangles from number `begin` on, those of errors where there are any.
void sum_near(uint begin, uint end, out vec3 all, out vec3 all_errors) {
    all = vec3(0);
    all_errors = vec3(0);
    if (TEAMS == 1) {
        for (uint k = begin; k < end; ++k) {
            add(k);
            if ((k - begin) % NEAR_RUN == NEAR_RUN - 1 || k + 1 == end) {
                all += sum;
                all_errors += error;
                sum = vec3(0);
                error = vec3(0);
            }
        }
        return;
    }
    // The group has one block, so that all its invocations reach each barrier.
    uint self = gl_LocalInvocationIndex, slot = self % BLOCK_RECEIVERS;
    for (uint at = begin; at < end; at += TEAMS * NEAR_RUN) {
        uint from = at + team() * NEAR_RUN, to = min(from + NEAR_RUN, end);
        sum = vec3(0);
        error = vec3(0);
        for (uint k = from; k < to; ++k) add(k);
        sums[self] = sum;
        if (ERRORS) errors[self] = error;
        barrier();
        for (uint k = 0; k < TEAMS && at + k * NEAR_RUN < end; ++k) {
            all += sums[k * BLOCK_RECEIVERS + slot];
            if (ERRORS) all_errors += errors[k * BLOCK_RECEIVERS + slot];
        }
        barrier();
    }
}
#endif
