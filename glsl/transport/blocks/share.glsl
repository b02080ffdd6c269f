// A tree's walk that the invocations of a group share: those that visit a node take it from the ones that wait, and
// add its children to them. What is found is sorted, so that neither the number of invocations nor their order shows.
// With LANES = 1 an invocation has an item of its own, and walks alone.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = LANES_ID) const uint LANES = 1; // invocations that share an item: 1, or all those of the group

uint item() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return LANES == 1 ? group * gl_WorkGroupSize.x + gl_LocalInvocationIndex : group;
}

// Nodes that are noted, and that wait to be visited, together: where there are more, one invocation walks alone.
const uint POOL = 1536;
// Levels of a tree that are left room for once many wait.
const uint DEEPEST = 128;
// What was found, from the front; nodes that wait, from the back. Small, so that many groups run at once.
shared uint pool[POOL];
shared uint found_count;
shared uint pushed[3];

uint found(uint k) { return pool[k]; }

// What the includer does with a node: it returns its second child to visit both; else 0, and a word to be noted unless
// that is NONE.
uint visit(uint node, out uint word);

// For all invocations of the group, from the root. False where not all that was found is noted, as the pool might have
// been too small.
// `cut` where not all was visited, either: the driver has ended the loop, or the tree is too deep.
bool walk_together(out bool cut) {
    uint self = gl_LocalInvocationIndex, top = 1;
    bool noted = true;
    if (self == 0) {
        pool[POOL - 1] = 0;
        found_count = 0;
        pushed[0] = 0;
    }
    barrier();
    for (uint round = 0; top > 0 && top < POOL; ++round) {
        // Each that is visited makes room for one of its two children. Once many wait, few go on: way down is left.
        uint room = POOL - top, taken = min(top, min(LANES, room > DEEPEST ? room - DEEPEST : 1));
        noted = noted && found_count + taken <= room - taken;
        uint node = self < taken ? pool[POOL - top + self] : 0;
        if (self == 0) pushed[(round + 1) % 3] = 0;
        barrier();
        top -= taken;
        if (self < taken) {
            uint word, right = visit(node, word);
            if (right != 0) {
                uint at = POOL - 1 - top - 2 * atomicAdd(pushed[round % 3], 1);
                pool[at] = right;
                pool[at - 1] = node + 1;
            } else if (word != NONE) {
                uint at = atomicAdd(found_count, 1);
                if (noted) pool[at] = word;
            }
        }
        barrier();
        top += 2 * pushed[round % 3];
    }
    cut = top != 0;
    return noted && !cut;
}

// Sorts the words that were found, for all invocations of the group: Batcher's bitonic sort, turned so that the smaller
// word always goes to the front, and words beyond the last need not be there.
void sort_found(uint count) {
    for (uint run = 2; run < 2 * count; run *= 2) {
        for (uint apart = run / 2; apart > 0; apart /= 2) {
            for (uint k = gl_LocalInvocationIndex; k < (count + run) / 2; k += LANES) {
                uint low = (k & ~(apart - 1)) << 1 | k & apart - 1;
                uint high = apart == run / 2 ? low ^ run - 1 : low + apart;
                if (high < count && pool[low] > pool[high]) {
                    uint word = pool[low];
                    pool[low] = pool[high];
                    pool[high] = word;
                }
            }
            barrier();
        }
    }
}
