#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Counts the entries of each block's lists, and notes them for `write`: one invocation alone the first ones, in the
// order of its walk; a group all of them, in sorted parts, wherever there is room.
UPDATES(runs)
UPDATES(counters)
UPDATES(decisions)
#include "transport/blocks/link/noted.glsl"
#include "transport/blocks/share.glsl"
#include "transport/blocks/link/walk.glsl"

uint count[LINK_KINDS] = uint[LINK_KINDS](0, 0, 0, 0, 0, 0);
uint first, kept = 0;
void on_emitter(uint kind, uint node) {
    // Decisions that are not kept are overwritten by the next one.
    decisions[first + min(kept, LINK_KEPT - 1)] = kind << LINK_SHIFT | node;
    kept += uint(listed(kind));
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
}

Seen block;
uint visit(uint node, out uint word) {
    Emitter e = emitters[node];
    uint kind = kind_of(block, node, e);
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
    // Sorted by kind: the order of the lists.
    word = listed(kind) ? kind << LINK_SHIFT | node : NONE;
    return kind == LINK_OPENED ? e.right : 0;
}

shared uint part, part_before, counts[LINK_KINDS];

// Notes the words so far as a part.
bool take(uint total) {
    uint self = gl_LocalInvocationIndex;
    if (total == 0) return true;
    if (self == 0) part = range.count + atomicAdd(counters[0].noted, PART_HEADER + total);
    sort_found(total);
    // Without room there are more entries than capacity, too.
    uint capacity = object_params[0].entry_capacity;
    uint room = range.count * NOTED_EXTRA + capacity + capacity / NOTED_LEAST * PART_HEADER;
    if (part + PART_HEADER + total > room) return true;
    if (self == 0) {
        decisions[part] = part_before;
        decisions[part + 1] = total;
        part_before = part;
    }
    for (uint k = self; k < total; k += LANES) decisions[part + PART_HEADER + k] = found(k);
    return true;
}

// A block's walk by the whole group; afterwards `count` is the whole block's.
void together(uint i) {
    uint self = gl_LocalInvocationIndex;
    if (self < LINK_KINDS) counts[self] = 0;
    if (self == 0) part_before = NONE;
    block = seen(range.first + i);
    if (!walk_together()) counters[0].unfinished = 1;
    for (uint k = 0; k < LINK_KINDS; ++k) if (count[k] > 0) atomicAdd(counts[k], count[k]);
    take(found_count);
    barrier();
    if (self == 0) decisions[i] = part_before;
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] = counts[k];
}

void main() {
    uint i = item();
    if (i >= range.count) return;
    first = i * LINK_KEPT;
    if (LANES > 1) together(i);
    else if (!walk(range.first + i, 0)) counters[0].unfinished = 1;
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    if (count[LINK_DIRECT] > MOST_DIRECT) counters[0].unfinished = 1;
    runs[i] = Runs(0, count[LINK_EXPANDED], count[LINK_DIRECT], count[LINK_AREA],
                   count[LINK_EDGE], count[LINK_DROPPED]);
}
