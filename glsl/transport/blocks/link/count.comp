#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// Counts the entries of each block's lists, and keeps the first ones in the order of the walk.
UPDATES(runs)
UPDATES(counters)
WRITES(decisions)
#include "transport/blocks/share.glsl"
#include "transport/blocks/link/walk.glsl"
#include "transport/blocks/link/parts.glsl"

const uint KIND_BITS = 3; // of a decision that has its kind in the low bits

uint count[LINK_KINDS] = uint[LINK_KINDS](0, 0, 0, 0, 0, 0);
uint first, kept = 0;
void on_emitter(uint kind, uint node) {
    // Decisions that are not kept are overwritten by the next one.
    decisions[first + min(kept, LINK_KEPT - 1)] = kind << LINK_SHIFT | node;
    kept += uint(listed(kind));
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
}

Seen block;
uint last = 0;
uint visit(uint node, out uint word) {
    Emitter e = emitters[node];
    uint kind = kind_of(block, node, e);
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] += uint(kind == k);
    // Sorted by node: the order in which one invocation alone meets them.
    uint by_node = node << KIND_BITS | kind;
    last = max(last, by_node);
    word = listed(kind) ? by_node : NONE;
    return kind == LINK_OPENED ? e.right : 0;
}

uint decision(uint by_node) { return (by_node & (1u << KIND_BITS) - 1) << LINK_SHIFT | by_node >> KIND_BITS; }

shared uint counts[LINK_KINDS];
shared uint last_of_all;
uint total_of_all;

void on_first(bool cut) {
    if (cut) counters[0].unfinished = 1;
    for (uint k = 0; k < LINK_KINDS; ++k) if (count[k] > 0) atomicAdd(counts[k], count[k]);
    atomicMax(last_of_all, last);
    total_of_all = found_count;
}

// Keeps the first decisions.
bool on_part(uint total) {
    uint wanted = min(total, LINK_KEPT - 1 - kept);
    for (uint k = gl_LocalInvocationIndex; k < wanted; k += LANES) decisions[first + kept + k] = decision(found(k));
    kept += wanted;
    return kept < LINK_KEPT - 1;
}

// A block's walk by the whole group; afterwards `count` is the whole block's.
void together(uint number) {
    uint self = gl_LocalInvocationIndex;
    if (self < LINK_KINDS) counts[self] = 0;
    if (self == 0) last_of_all = 0;
    block = seen(number);
    bool found_all = walk_by_parts(object_params[0].nodes);
    uint total = total_of_all;
    if (!found_all && self == 0) {
        // One invocation finds the first decisions again.
        kept = 0;
        for (uint node = 0; kept < min(total, LINK_KEPT - 1);) {
            Emitter e = emitters[node];
            uint kind = kind_of(block, node, e);
            if (listed(kind)) decisions[first + kept++] = kind << LINK_SHIFT | node;
            node = kind == LINK_OPENED ? node + 1 : e.skip;
        }
    }
    for (uint k = 0; k < LINK_KINDS; ++k) count[k] = counts[k];
    // The same last word as a walk alone leaves, where decisions that are not kept are overwritten.
    bool ends_listed = listed(last_of_all & (1u << KIND_BITS) - 1);
    if (self == 0 && (!ends_listed || total >= LINK_KEPT)) decisions[first + min(total, LINK_KEPT - 1)] = decision(last_of_all);
}

void main() {
    uint i = item();
    if (i >= range.count) return;
    first = i * LINK_KEPT;
    if (LANES > 1) together(range.first + i);
    else if (!walk(range.first + i, 0)) counters[0].unfinished = 1;
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    if (count[LINK_DIRECT] > MOST_DIRECT) counters[0].unfinished = 1;
    runs[i] = Runs(0, count[LINK_EXPANDED], count[LINK_DIRECT], count[LINK_AREA],
                   count[LINK_EDGE], count[LINK_DROPPED]);
}
