// A walk over a tree that the invocations of a group share: each takes one of the waiting nodes, visits it, and adds
// its children to those that wait. The results are sorted, so that they depend neither on the number of invocations nor
// on their order. With LANES = 1 each invocation has an item of its own, and walks alone. The includer defines WORDS:
// room for so many words.
#include "transport/blocks/lanes.glsl"

// Room for nodes that wait. Once many do, room is left for a way down of DEEPEST levels.
const uint WAITING = 640;
const uint DEEPEST = 128;
// Words that were found, from the front, a copy of them and eight more; nodes that wait, from the back. Small, so that
// many groups run at once.
const uint POOL = 2 * WORDS + 8 + WAITING;
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
        if (words + taken >= WORDS) {
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

const uint SPLITTERS = 32;
const uint EACH = (WORDS + 2 * LANES - 1) / (2 * LANES); // words of an invocation are sorted two at once
shared uint splitters[SPLITTERS], begins[SPLITTERS], sizes[SPLITTERS / 8 + 1];

uvec4 words_at(uvec4 at) { return uvec4(pool[at.x], pool[at.y], pool[at.z], pool[at.w]); }

// How many splitters are smaller than each of these words.
uvec2 bucket_of(uvec2 words) {
    uvec2 count = uvec2(0);
    for (uint step = SPLITTERS / 2; step > 0; step /= 2) {
        uvec2 at = count + step - 1;
        count += step * uvec2(lessThan(uvec2(splitters[at.x], splitters[at.y]), words));
    }
    return count;
}

// 1 where a word is smaller, else 0.
uvec4 less(uvec4 words, uint than) { return uvec4(lessThan(words, uvec4(than))); }

// How many of the copy's words from `begin` on are smaller than this one: none from `end` on is.
uint smaller(uint word, uint begin, uint end) {
    uvec4 count = uvec4(0);
    for (uint at = WORDS + begin; at < WORDS + end; at += 8) {
        count += less(words_at(at + uvec4(0, 1, 2, 3)), word) + less(words_at(at + uvec4(4, 5, 6, 7)), word);
    }
    return count.x + count.y + (count.z + count.w);
}

// Where a bucket begins.
uint begin_of(uint bucket) { return begins[bucket] + sizes[bucket / 8]; }

// Sorts the words, all of them different. Some of them, sorted by counting which are smaller, split all into buckets;
// in a bucket a word's place is again how many are smaller.
void sort_found(uint count) {
    uint self = gl_LocalInvocationIndex, known = min(count, SPLITTERS - 1);
    for (uint k = self; k < SPLITTERS; k += LANES) {
        pool[WORDS + k] = NONE;
        if (k < known) pool[WORDS + k] = pool[k * count / known];
        splitters[k] = NONE;
        begins[k] = 0;
    }
    barrier();
    for (uint k = self; k < known; k += LANES) {
        uint word = pool[WORDS + k];
        splitters[smaller(word, 0, SPLITTERS)] = word;
    }
    barrier();
    uvec2 words[EACH], buckets[EACH], places[EACH];
    for (uint e = 0; e < EACH && 2 * LANES * e < count; ++e) {
        uvec2 at = self + LANES * (2 * e + uvec2(0, 1)), near = min(at, count - 1);
        words[e] = uvec2(pool[near.x], pool[near.y]);
        buckets[e] = bucket_of(words[e]);
        for (uint j = 0; j < 2; ++j) if (at[j] < count) places[e][j] = atomicAdd(begins[buckets[e][j]], 1);
    }
    barrier();
    if (self < SPLITTERS / 8) {
        uint sum = 0;
        for (uint k = 8 * self; k < 8 * self + 8; ++k) {
            uint size = begins[k];
            begins[k] = sum;
            sum += size;
        }
        sizes[self + 1] = sum;
        if (self == 0) sizes[0] = 0;
    }
    if (self < 8) pool[WORDS + count + self] = NONE; // beyond the last bucket
    barrier();
    if (self == 0) for (uint k = 1; k <= SPLITTERS / 8; ++k) sizes[k] += sizes[k - 1];
    barrier();
    for (uint e = 0; e < EACH && 2 * LANES * e < count; ++e) for (uint j = 0; j < 2; ++j) {
        uint at = self + LANES * (2 * e + j);
        if (at < count) pool[WORDS + begin_of(buckets[e][j]) + places[e][j]] = words[e][j];
    }
    barrier();
    for (uint e = 0; e < EACH && 2 * LANES * e < count; ++e) for (uint j = 0; j < 2; ++j) {
        uint at = self + LANES * (2 * e + j), bucket = buckets[e][j], begin = begin_of(bucket);
        if (at >= count) continue;
        uint end = bucket + 1 < SPLITTERS ? begin_of(bucket + 1) : count;
        pool[begin + smaller(words[e][j], begin, end)] = words[e][j];
    }
    barrier();
}
