// A walk over a tree that the invocations of a group share: each takes one of the waiting nodes, visits it, and adds
// its children to those that wait. The results are sorted, so that they depend neither on the number of invocations nor
// on their order. With LANES = 1 each invocation has an item of its own, and walks alone.
layout(local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID) in;
layout(constant_id = LANES_ID) const uint LANES = 1; // invocations that share an item: 1, or all those of the group

uint item() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return LANES == 1 ? group * gl_WorkGroupSize.x + gl_LocalInvocationIndex : group;
}

// Room for the words that are noted and the nodes that wait, together: if there are more, one invocation walks alone.
const uint POOL = 1536;
// Once many nodes wait, room is left for a way down of this many levels.
const uint DEEPEST = 128;
// Words that were found, from the front; nodes that wait, from the back. Small, so that many groups run at once.
shared uint pool[POOL];
shared uint found_count;
shared uint pushed[3];

uint found(uint k) { return pool[k]; }

// What the includer does with a node: it returns the second child to have both visited; else 0, with a word to be
// noted, or NONE.
uint visit(uint node, out uint word);

// All invocations of the group walk from the root. Returns false if the pool may have been too small for all words.
// `cut`: not all nodes were visited, either: the driver has ended the loop, or the tree is too deep.
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
        // A visited node makes room for one of its two children. Once many wait, few are visited at a time: that leaves
        // room for the way down.
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

// Sorts the words that were found, by all invocations of the group: Batcher's bitonic sort, arranged so that the
// smaller word always goes to the front, and words beyond the last need not exist.
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
