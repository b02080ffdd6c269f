#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#define COUNTED_GROUPS
#include "invocation.glsl"

// Merges a receiver's new links into its list and takes the removed ones out, in the order of the emitters. Links whose
// form factor is out of date are marked; until it is computed, a new link transfers as much per area as the link before
// it.
layout(push_constant, scalar) uniform push_block { Range range; };
READS(active_receivers)
READS(clusters)
READS(change_flags)
READS(edits)
READS(added_links)
READS(removed_links)
READS(counters)
UPDATES(spans)
UPDATES(links)
UPDATES(factors)
UPDATES(stale)
UPDATES(stale_counts)

// If all links that a receiver makes existed before and none is removed, its list stays where it is.
void mark(uint receiver, Span edit, Span span) {
    uint at = span.link, last = at + span.links, end = last;
    uint first = edit.links > 0 ? added_links[edit.link] : 0, waits = 0;
    while (at < end) {
        uint middle = (at + end) / 2;
        if (links[middle].emitter < first) at = middle + 1;
        else end = middle;
    }
    for (uint j = edit.link; j < edit.link + edit.links; ++j) {
        uint make = added_links[j];
        while (at < last && links[at].emitter < make) at++;
        if (at < last && ((change_flags[receiver] | change_flags[make]) & ALTERED_MOVED) != 0 && stale[at] == 0) {
            stale[at] = 1;
            waits++;
        }
    }
    stale_counts[receiver] += waits;
}

void main() {
    uint place = invocation();
    if (place >= counters[0].receivers || counters[0].overflow != 0 || counters[0].unfinished != 0) return;
    uint receiver = active_receivers[range.first + place];
    Span edit = edits[receiver];
    Span span = spans[receiver];
    if (edit.edges == 0) {
        mark(receiver, edit, span);
        return;
    }
    uint i = span.link, last = i + span.links;
    uint j = edit.link, made_end = j + edit.links;
    uint k = edit.area, undone_end = k + edit.areas;
    uint first = edit.edge, to = first, waits = 0;
    vec3 share = vec3(0);
    while (i < last || j < made_end) {
        uint have = i < last ? links[i].emitter : NONE;
        uint make = j < made_end ? added_links[j] : NONE;
        uint undo = k < undone_end ? removed_links[k] : NONE;
        // If the frame runs again, part of this is done already.
        bool absent = undo < have;
        bool old = !absent && have <= make && i < last, fresh = !absent && make <= have && j < made_end;
        bool gone = old && undo == have;
        vec3 factor = vec3(0);
        if (old) {
            factor = factors[i];
            float area = clusters[have].area;
            if (area > 0.0) share = factor / area;
        }
        if (fresh || (old && !gone)) {
            if (!old) factor = share * clusters[make].area;
            uint emitter = min(have, make);
            uint touched = fresh ? (change_flags[receiver] | change_flags[emitter]) & ALTERED_MOVED : 0;
            uint waiting_ = old ? stale[i] | touched : 1;
            links[to] = Link(receiver, emitter);
            factors[to] = factor;
            stale[to] = waiting_;
            waits += waiting_;
            to++;
        }
        if (absent || gone) k++;
        if (old) i++;
        if (fresh) j++;
    }
    spans[receiver].link = first;
    spans[receiver].links = to - first;
    stale_counts[receiver] = waits;
}
