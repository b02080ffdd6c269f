#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Writes each block's lists where the scan placed them: the decisions that `count` kept, then those of another walk.
READS(runs)
READS(counters)
READS(decisions)
WRITES(entries)
#include "transport/blocks/share.glsl"
#include "transport/blocks/link/walk.glsl"
#include "transport/blocks/link/parts.glsl"

uint at[LINK_KINDS];
void on_emitter(uint kind, uint node) {
    uint place = 0;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) place = kind == k ? at[k] : place;
    if (listed(kind)) entries[place] = node;
    for (uint k = LINK_EXPANDED; k <= LINK_EDGE; ++k) at[k] += uint(kind == k);
}

Seen block;
uint visit(uint node, out uint word) {
    Emitter e = emitters[node];
    uint kind = kind_of(block, node, e);
    // Sorted by kind: the order of the lists.
    word = listed(kind) ? kind << LINK_SHIFT | node : NONE;
    return kind == LINK_OPENED ? e.right : 0;
}

shared uvec4 kinds_before[MOST_LANES];

// The kinds in the order of the lists, and of their numbers; 1 in the component of the decision's kind, else 0; where
// each kind begins.
const uvec4 KINDS = LINK_EXPANDED + uvec4(0, 1, 2, 3);
uvec4 one_of(uint decision) { return uvec4(equal(KINDS, uvec4(decision >> LINK_SHIFT))); }
uvec4 begins(Runs one) { return one.first + uvec4(0, one.expanded, one.expanded + one.direct, one.expanded + one.direct + one.area); }

// Writes the decisions that `count` kept, by kind: each invocation takes a run of them, and counts those before it.
void write_known(uint first, Runs one, uint total) {
    uint self = gl_LocalInvocationIndex, each = (total + LANES - 1) / LANES;
    uint begin = first + min(self * each, total), end = first + min(self * each + each, total);
    uvec4 own = uvec4(0);
    for (uint k = begin; k < end; ++k) own += one_of(decisions[k]);
    kinds_before[self] = own;
    barrier();
    for (uint step = 1; step < LANES; step *= 2) {
        uvec4 other = self >= step ? kinds_before[self - step] : uvec4(0);
        barrier();
        kinds_before[self] += other;
        barrier();
    }
    uvec4 place = begins(one) + kinds_before[self] - own;
    for (uint k = begin; k < end; ++k) {
        uint decision = decisions[k];
        uvec4 here = one_of(decision);
        uvec4 at = place * here;
        entries[at.x + at.y + at.z + at.w] = decision & (1u << LINK_SHIFT) - 1;
        place += here;
    }
}

uvec4 places; // of the next entries, by kind
shared uint kinds_begin[4];
void on_first(bool cut) {}
bool on_part(uint total) {
    uint self = gl_LocalInvocationIndex;
    if (self < 4) kinds_begin[self] = total;
    barrier();
    for (uint k = self; k < total; k += LANES) {
        uint kind = found(k) >> LINK_SHIFT;
        if (k == 0 || found(k - 1) >> LINK_SHIFT != kind) kinds_begin[kind - KINDS.x] = k;
    }
    barrier();
    uint begin = total;
    for (uint kind = 4; kind-- > 0;) {
        uint end = begin;
        begin = min(begin, kinds_begin[kind]);
        for (uint k = begin + self; k < end; k += LANES) entries[places[kind] + k - begin] = found(k) & (1u << LINK_SHIFT) - 1;
        places[kind] += end - begin;
    }
    return true;
}

void main() {
    uint i = item();
    if (i >= range.count || counters[0].entries > object_params[0].entry_capacity) return;
    Runs one = runs[i];
    uint total = one.expanded + one.direct + one.area + one.edge;
    if (LANES > 1) {
        if (total < LINK_KEPT) {
            write_known(i * LINK_KEPT, one, total);
            return;
        }
        block = seen(range.first + i);
        places = begins(one);
        uint nodes = object_params[0].nodes;
        if (walk_by_parts(total > POOL ? (nodes + 1) / 2 : nodes)) return;
    }
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    for (uint k = 0; k < 4; ++k) at[KINDS[k]] = begins(one)[k];
    uint node = 0, known = min(total, LINK_KEPT - 1);
    for (uint k = 0; k < known; ++k) {
        uint decision = decisions[i * LINK_KEPT + k];
        node = decision & ((1u << LINK_SHIFT) - 1);
        on_emitter(decision >> LINK_SHIFT, node);
    }
    // The walk goes on after the last of them.
    if (known < total) walk(range.first + i, emitters[node].skip);
}
