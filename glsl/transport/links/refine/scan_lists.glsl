// Where each receiver's lists begin: a prefix sum over one level by one work group.
// A list that does not fit is emptied and the overflow noted: the frame then runs again with more capacity.
// The includer declares LISTS, returns their capacities, and notes the capacities that they need.
layout(push_constant, scalar) uniform push_block { Range range; uint keep; };
READS(object_params)
READS(order)
UPDATES(counters)

uvec4 rooms();
void note(uvec4 total);

#define SUM uvec4
#include "scan.glsl"

void main() {
    uvec2 run = own_run(range.count);
    uvec4 sum = uvec4(0);
    for (uint i = run.x; i < run.y; ++i) {
        Span span = LISTS[order[range.first + i]];
        sum += uvec4(span.links, span.areas, span.edges, span.hands);
    }

    uvec4 before = sum_before(sum);
    uvec4 base = uvec4(counters[0].links, counters[0].areas, counters[0].edges, counters[0].hands);
    uvec4 total = base + sum_of_all();
    // Counts stay right beyond the capacity, so that one more frame with the right capacity is enough; only emitters
    // that could not be handed down leave the levels below uncounted.
    bvec4 fit = lessThanEqual(total, rooms());
    bool links_fit = fit.x && fit.y && fit.z, hands_fit = fit.w;
    uvec4 kept = uvec4(uvec3(links_fit ? 1 : 0), hands_fit ? 1 : 0);
    uvec4 at = base + before;
    for (uint i = run.x; i < run.y; ++i) {
        uint receiver = order[range.first + i];
        Span span = LISTS[receiver];
        uvec4 count = uvec4(span.links, span.areas, span.edges, span.hands);
        LISTS[receiver] = Span(at.x, count.x * kept.x, at.y, count.y * kept.y,
                               at.z, count.z * kept.z, at.w, count.w * kept.w);
        at += count;
    }

    // Every invocation has read the counters: a barrier alone orders shared memory only.
    memoryBarrierBuffer();
    barrier();
    if (gl_LocalInvocationIndex == 0) {
        note(total);
        counters[0].required_hands = max(counters[0].required_hands, total.w);
        if (!links_fit || !hands_fit) counters[0].overflow = 1;
        counters[0].links = total.x;
        counters[0].areas = total.y;
        counters[0].edges = total.z;
        counters[0].hands = total.w;
        if (keep != 0) counters[0].kept = total.w;
    }
}
