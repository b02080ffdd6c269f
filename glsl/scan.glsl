// A prefix sum by one work group. Each invocation contributes a sum, of a run of the elements for example. The includer
// defines SUM, the type of the elements: integers, so that the order of additions does not matter.
layout(constant_id = WIDE_ID) const uint SCAN_SIZE = 256; // its invocations: a power of two
layout(local_size_x = 256, local_size_x_id = WIDE_ID) in;

shared SUM sums[MOST_WIDE];

// This invocation's run among `count` elements: the first, and the one after the last.
uvec2 own_run(uint count) {
    uint each = (count + SCAN_SIZE - 1) / SCAN_SIZE;
    uint first = min(count, gl_LocalInvocationIndex * each);
    return uvec2(first, min(count, first + each));
}

// The sum over the runs before this invocation's. All invocations must call it, and pass a barrier before they call it
// again.
SUM sum_before(SUM own) {
    uint self = gl_LocalInvocationIndex;
    SUM sum = own;
    sums[self] = sum;
    // Four neighbours a step: half the barriers of two.
    for (uint step = 1; step < SCAN_SIZE; step *= 4) {
        barrier();
        SUM near = self >= step ? sums[self - step] : SUM(0);
        SUM middle = self >= 2 * step ? sums[self - 2 * step] : SUM(0);
        SUM far = self >= 3 * step ? sums[self - 3 * step] : SUM(0);
        barrier();
        sum += near + middle + far;
        sums[self] = sum;
    }
    barrier();
    return sum - own;
}

// The sum over all runs, after `sum_before`.
SUM sum_of_all() { return sums[SCAN_SIZE - 1]; }
