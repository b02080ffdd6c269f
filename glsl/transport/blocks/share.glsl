// A walk over a tree that the invocations of a group share: each takes one of the waiting nodes, visits it, and adds
// its children to those that wait. The results are sorted, so that they depend neither on the number of invocations nor
// on their order. With LANES = 1 each invocation has an item of its own, and walks alone. The includer defines WORDS:
// room for so many words, a multiple of SORTED.
#include "transport/blocks/lanes.glsl"

// Room for nodes that wait. Once many do, room is left for a way down of DEEPEST levels.
const uint WAITING = 640;
const uint DEEPEST = 128;
// Words that were found, from the front, and a copy of them; nodes that wait, from the back. Small, so that many groups
// run at once.
const uint POOL = 2 * WORDS + WAITING;
shared uint pool[POOL];
shared uint found_count;
shared uint pushed[3];

uint found(uint k) { return pool[k]; }

// What the includer does with a node: it returns the second child to have both visited; else 0, with a word to be
// noted, or NONE.
uint visit(uint node, out uint word);

// What it does with all words so far, where there is no room for more. Returning false ends the walk.
bool take(uint total);

// All invocations of the group walk. Returns false if not all nodes were visited: there was no room, the driver has
// ended the loop, or the tree is too deep.
bool walk_together() {
    uint self = gl_LocalInvocationIndex, top = 1;
    if (self == 0) {
        pool[POOL - 1] = 0;
        found_count = 0;
        pushed[0] = 0;
    }
    barrier();
    for (uint round = 0; top > 0 && top < WAITING; ++round) {
        // A visited node makes room for one of its two children. Once many wait, few are visited at a time: that leaves
        // room for the way down.
        uint room = WAITING - top, taken = min(top, min(LANES, room > DEEPEST ? room - DEEPEST : 1));
        uint node = self < taken ? pool[POOL - top + self] : 0, words = found_count;
        if (self == 0) pushed[(round + 1) % 3] = 0;
        barrier();
        if (words + taken > WORDS) {
            if (!take(words)) return false;
            if (self == 0) found_count = 0;
            barrier();
        }
        top -= taken;
        if (self < taken) {
            uint word, right = visit(node, word);
            if (right != 0) {
                uint at = POOL - 1 - top - atomicAdd(pushed[round % 3], 2);
                pool[at] = right;
                pool[at - 1] = node + 1;
            } else if (word != NONE) {
                pool[atomicAdd(found_count, 1)] = word;
            }
        }
        barrier();
        top += pushed[round % 3];
    }
    return top == 0;
}

const uint SORTED_RUN = 64;
const uint SORTED = 4 * SORTED_RUN; // four runs are searched at once: none waits for the other

uvec4 words_at(uvec4 at) { return uvec4(pool[at.x], pool[at.y], pool[at.z], pool[at.w]); }

// 1 where a word is smaller, else 0.
uvec4 less(uvec4 words, uint word) { return uvec4(lessThan(words, uvec4(word))); }

uint sum_of(uvec4 v) { return v.x + v.y + (v.z + v.w); }

// How many of the words of four sorted runs are smaller than this one.
uint smaller(uint word, uint first) {
    const uvec4 begin = first + SORTED_RUN * uvec4(0, 1, 2, 3);
    uvec4 at = begin;
    at += 32 * less(words_at(at + 31), word);
    at += 16 * less(words_at(at + 15), word);
    at += 8 * less(words_at(at + 7), word);
    at += 4 * less(words_at(at + 3), word);
    at += 2 * less(words_at(at + 1), word);
    at += less(words_at(at), word);
    return sum_of(at + less(words_at(at), word) - begin);
}

// Sorts the words, all of them different: each run by counting which of it are smaller; then a word's
// place is how many are smaller in all runs. NONE fills the last runs.
void sort_found(uint count) {
    const uint copy = WORDS;
    uint filled = (count + SORTED - 1) & ~(SORTED - 1);
    for (uint k = count + gl_LocalInvocationIndex; k < filled; k += LANES) pool[k] = pool[copy + k] = NONE;
    barrier();
    for (uint k = gl_LocalInvocationIndex; k < count; k += LANES) {
        uint word = pool[k], first = k & ~(SORTED_RUN - 1);
        uvec4 place = uvec4(0);
        for (uint other = first; other < first + SORTED_RUN; other += 8) {
            place += less(words_at(other + uvec4(0, 1, 2, 3)), word) + less(words_at(other + uvec4(4, 5, 6, 7)), word);
        }
        pool[copy + first + sum_of(place)] = word;
    }
    barrier();
    for (uint k = gl_LocalInvocationIndex; k < count; k += LANES) {
        uint word = pool[copy + k], place = 0;
        for (uint first = 0; first < count; first += SORTED) place += smaller(word, copy + first);
        pool[place] = word;
    }
    barrier();
}
