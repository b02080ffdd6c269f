// The expansion of a block's emitters about its centre. Each run of EXPAND_RUN emitters is summed by itself, then these
// sums are, in their order: so runs may be summed at once.
#include "transport/blocks/lanes.glsl"

const uint EXPAND_RUN = 8; // emitters that are summed by themselves
const uint EXPAND_RUNS = 32; // such runs that a group sums at once

// The expansion of one run of emitters: the includer's.
Expansion sum_of(uint block, uint first, uint last);

const Expansion NOTHING = Expansion(vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0),
                                    vec3(0), vec3(0), vec3(0));

Expansion plus(Expansion a, Expansion b) {
    return Expansion(a.value + b.value, a.x + b.x, a.y + b.y, a.z + b.z, a.xx + b.xx, a.yy + b.yy, a.zz + b.zz,
        a.yz + b.yz, a.zx + b.zx, a.xy + b.xy, a.error + b.error, a.bend + b.bend);
}

// An expansion's numbers, and one more so that lanes meet in no bank of memory.
const uint NUMBERS = 36, APART = 37;
shared float sums[EXPAND_RUNS * APART];

void put(uint at, vec3 v) {
    sums[at] = v.x;
    sums[at + 1] = v.y;
    sums[at + 2] = v.z;
}
vec3 got(uint at) { return vec3(sums[at], sums[at + 1], sums[at + 2]); }

// The sum of all runs, for the first invocation of the group.
Expansion sum_together(uint block, uint first, uint last) {
    uint self = gl_LocalInvocationIndex;
    float own[2] = float[2](0, 0); // sums of the numbers self and self + LANES: two rounds cover all NUMBERS
    for (uint begin = first; begin < last; begin += EXPAND_RUNS * EXPAND_RUN) {
        uint runs = min((last - begin + EXPAND_RUN - 1) / EXPAND_RUN, EXPAND_RUNS);
        barrier();
        for (uint run = self; run < runs; run += LANES) {
            uint from = begin + run * EXPAND_RUN, at = run * APART;
            Expansion e = sum_of(block, from, min(from + EXPAND_RUN, last));
            put(at, e.value);
            put(at + 3, e.x); put(at + 6, e.y); put(at + 9, e.z);
            put(at + 12, e.xx); put(at + 15, e.yy); put(at + 18, e.zz);
            put(at + 21, e.yz); put(at + 24, e.zx); put(at + 27, e.xy);
            put(at + 30, e.error); put(at + 33, e.bend);
        }
        barrier();
        for (uint k = 0; k < 2; ++k) {
            uint number = self + k * LANES;
            if (number < NUMBERS) for (uint run = 0; run < runs; ++run) own[k] += sums[run * APART + number];
        }
    }
    barrier();
    for (uint k = 0; k < 2; ++k) if (self + k * LANES < NUMBERS) sums[self + k * LANES] = own[k];
    barrier();
    return Expansion(got(0), got(3), got(6), got(9), got(12), got(15), got(18), got(21), got(24), got(27), got(30), got(33));
}

// The sum of all runs; of several invocations, the first one's counts.
Expansion sum_of_runs(uint block, uint first, uint last) {
    if (LANES > 1) return sum_together(block, first, last);
    Expansion sum = NOTHING;
    for (uint at = first; at < last; at += EXPAND_RUN) sum = plus(sum, sum_of(block, at, min(at + EXPAND_RUN, last)));
    return sum;
}
