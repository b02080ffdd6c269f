#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Writes each block's lists where the scan placed them: what `count` noted, and where one invocation walks for a block
// the rest of its walk.
READS(runs)
READS(counters)
READS(decisions)
WRITES(entries)
#include "transport/blocks/lanes.glsl"
#include "transport/blocks/link/walk.glsl"
#include "transport/blocks/link/noted.glsl"

uint at[LINK_KINDS];
void on_emitter(uint kind, uint node) {
    uint place = 0;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) place = kind == k ? at[k] : place;
    if (listed(kind)) entries[place] = node;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) at[k] += uint(kind == k);
}

// The lists of a block by one invocation.
void alone(uint i, Runs one) {
    at[LINK_EXPANDED] = one.first;
    at[LINK_DIRECT] = at[LINK_EXPANDED] + one.expanded;
    at[LINK_AREA] = at[LINK_DIRECT] + one.direct;
    at[LINK_EDGE] = at[LINK_AREA] + one.area;
    uint total = at[LINK_EDGE] + one.edge - one.first, node = 0, known = min(total, LINK_KEPT - 1);
    for (uint k = 0; k < known; ++k) {
        uint decision = decisions[i * LINK_KEPT + k];
        node = decision & ((1u << LINK_SHIFT) - 1);
        on_emitter(decision >> LINK_SHIFT, node);
    }
    // The walk goes on after the last of them.
    if (known < total) walk(range.first + i, emitters[node].skip);
}

shared uint part_words[WORDS];

uvec4 loaded(uvec4 at) { return uvec4(decisions[at.x], decisions[at.y], decisions[at.z], decisions[at.w]); }

// Four places, as far apart as there are invocations.
uvec4 apart(uint first) { return uvec4(first, first + LANES, first + 2 * LANES, first + 3 * LANES); }

// Loads a part's words; NONE fills the rest.
void load(uint first, uint total) {
    barrier();
    for (uint k = gl_LocalInvocationIndex; k < WORDS; k += 4 * LANES) {
        uvec4 at = apart(k), words = loaded(first + min(at, total - 1));
        for (uint j = 0; j < 4; ++j) if (at[j] < WORDS) part_words[at[j]] = at[j] < total ? words[j] : NONE;
    }
    barrier();
}

// How many of the part's words are smaller than each of these; not all are.
uvec4 smaller(uvec4 words) {
    uvec4 count = uvec4(0);
    for (uint step = WORDS / 2; step > 0; step /= 2) {
        uvec4 at = count + step - 1;
        uvec4 known = uvec4(part_words[at.x], part_words[at.y], part_words[at.z], part_words[at.w]);
        count += step * uvec4(lessThan(known, words));
    }
    return count;
}

// The same by a group: a word's place is how many of the block are smaller. Each invocation takes four at once.
void together(uint i, uint first) {
    // Each part of a block stands before the one that was found last.
    for (uint part = decisions[i], last = NONE; part < last; last = part, part = decisions[part]) {
        uint total = min(decisions[part + 1], WORDS);
        for (uint begin = 0; begin < total; begin += 4 * LANES) {
            uvec4 place = apart(begin + gl_LocalInvocationIndex);
            bvec4 mine = lessThan(place, uvec4(total));
            uvec4 words = loaded(part + PART_HEADER + min(place, total - 1));
            for (uint other = decisions[i], after = NONE; other < after; after = other, other = decisions[other]) {
                if (other == part) continue;
                load(other + PART_HEADER, min(decisions[other + 1], WORDS));
                place += smaller(words);
            }
            for (uint j = 0; j < 4; ++j) if (mine[j]) entries[first + place[j]] = words[j] & (1u << LINK_SHIFT) - 1;
        }
    }
}

void main() {
    uint i = item();
    if (i >= range.count || counters[0].entries > object_params[0].entry_capacity) return;
    Runs one = runs[i];
    if (LANES > 1) together(i, one.first);
    else alone(i, one);
}
