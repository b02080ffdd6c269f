#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"

// Tests what kernels rely on and some drivers get wrong: each probe has an exact answer, in whole words. Numbers come
// from a buffer, so that no compiler knows them.
layout(local_size_x = GROUP_SIZE) in;
layout(constant_id = 0) const uint PROBE = 0;

struct Uneven {
    float before;
    vec3 middle;
    float after;
};

// The number of rows, then the rows, of GROUP_SIZE numbers each.
layout(set = 0, binding = 0, scalar) restrict readonly buffer number_block { uint rows; uint numbers[]; };
layout(set = 0, binding = 1, scalar) restrict readonly buffer term_block { float terms[]; };
layout(set = 0, binding = 2, scalar) restrict readonly buffer uneven_block { Uneven uneven[]; };
layout(set = 0, binding = 3, scalar) restrict buffer answer_block { uint probed[]; };
// The groups of two indirect dispatches.
layout(set = 0, binding = 4, scalar) restrict writeonly buffer count_block { uint counts[]; };
layout(push_constant, scalar) uniform push_block { uint pushed[32]; };

shared uint parts[GROUP_SIZE];

uint number(uint row) {
    return numbers[row * GROUP_SIZE + gl_LocalInvocationIndex];
}

// Steps by three rows where a number has one of its two lowest bits, else by one; the inner loop assigns `hit` in every
// iteration, and `hit` indexes a buffer after the loop.
uint nested() {
    uint i = 0, sum = 0;
    for (;;) {
        if (i >= rows) break;
        uint hit = 0;
        bool found = false;
        for (;;) {
            uint r = number(i);
            bool far = (r & 3) != 0;
            found = far && (r & 4) != 0;
            hit = i;
            i = far ? i + 3 : i + 1;
            if (found || i >= rows) break;
        }
        if (found) sum += (number(hit) & 4) != 0 ? hit * 7 + 1 : 1000000;
    }
    return sum;
}

// 300 times `rows` iterations.
uint long_loops() {
    uint count = 0;
    for (uint i = 0; i < rows; ++i) {
        for (uint j = 0; j < 300; ++j) count += (number(i) | 1) & 1;
    }
    return count;
}

// Every number of the group, after barriers, in the reverse order; then their sum.
uint shared_memory() {
    uint self = gl_LocalInvocationIndex;
    parts[self] = number(0);
    barrier();
    uint other = parts[GROUP_SIZE - 1 - self];
    barrier();
    parts[self] = other;
    for (uint half_size = GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
        barrier();
        if (self < half_size) parts[self] += parts[self + half_size];
    }
    barrier();
    return parts[0] + other;
}

// The place of this lane, counted by subgroups.
uint lane() {
    return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID;
}

// The other lane of each pair, while the lanes of other pairs have left the loop; from memory where there are no pairs.
uint shuffled() {
    uint sum = 0, last = lane() / 2 % 5;
    for (uint row = 0; row <= last; ++row) {
        uint other = subgroupShuffle(numbers[row * GROUP_SIZE + lane()], gl_SubgroupInvocationID ^ 1);
        sum += gl_SubgroupSize < 2 ? numbers[row * GROUP_SIZE + (lane() ^ 1)] : other;
    }
    return sum;
}

// Every second lane asks the next one, which does not take the branch.
uint inactive() {
    uint own = numbers[lane()];
    if ((lane() & 1) == 0) own = subgroupShuffle(own, gl_SubgroupInvocationID + 1);
    return own;
}

// What share of 64 of the invocations that each subgroup says to have are there.
uint full() {
    parts[gl_LocalInvocationIndex] = gl_SubgroupID;
    barrier();
    uint count = 0;
    for (uint k = 0; k < GROUP_SIZE; ++k) count += uint(parts[k] == gl_SubgroupID);
    return 64 * count / min(gl_SubgroupSize, GROUP_SIZE);
}

// A loop beside whose condition a counter of 64 bits goes up from 0, for compilers that want a proof that it ends.
uint bounded() {
    uvec2 bound = uvec2(0);
    uint count = 0, last = number(0) % rows;
    for (;;) {
        if (all(equal(bound, uvec2(~0u)))) break;
        bound += uvec2(bound.y == ~0u ? 1 : 0, 1);
        if (count >= last) break;
        count += 1 + (number(count) & 1);
    }
    return count + bound.y;
}

// The value of the invocation before; the first one has none, and must not get what lies there.
uint previous() {
    int before = int(gl_LocalInvocationIndex) - 1;
    parts[gl_LocalInvocationIndex] = number(0);
    barrier();
    return before < 0 ? 7u : parts[before];
}

// A walk through 1 KiB of each invocation's own memory, which changes it; then all of it.
uint private_array() {
    uint kept[256], place = 0, sum = 0;
    for (uint k = 0; k < 256; ++k) kept[k] = number(k);
    for (uint k = 0; k < 1000; ++k) {
        uint found = kept[place];
        kept[place] = found * 5 + k;
        place = (found >> 3) % 256;
    }
    for (uint k = 0; k < 256; ++k) sum = sum * 31 + kept[k];
    return sum;
}

void main() {
    uint answer = 0, at = gl_LocalInvocationIndex;
    if (PROBE == 0) answer = nested();
    if (PROBE == 1) answer = long_loops();
    if (PROBE == 2) answer = floatBitsToUint(terms[0] + terms[1]);
    if (PROBE == 3) {
        precise float product = terms[0] * terms[1];
        precise float rest = product + terms[2];
        answer = floatBitsToUint(rest);
    }
    if (PROBE == 4) answer = floatBitsToUint(terms[0] * terms[1]);
    if (PROBE == 5) {
        Uneven own = uneven[gl_LocalInvocationIndex];
        answer = floatBitsToUint(own.before + 2 * own.middle.x + 4 * own.middle.y + 8 * own.middle.z + 16 * own.after);
    }
    if (PROBE == 6) answer = shared_memory();
    if (PROBE == 7) {
        at = lane();
        answer = shuffled();
    }
    if (PROBE == 8) {
        at = lane();
        answer = inactive();
    }
    if (PROBE == 9) answer = pushed[number(0) % 32];
    if (PROBE == 10) answer = full();
    if (PROBE == 11) answer = bounded();
    if (PROBE == 12) answer = previous();
    if (PROBE == 13) answer = private_array();
    if (PROBE == 14 && at == 0) {
        uint groups[6] = uint[6](3, 1, 1, 0, 1, 1);
        for (uint k = 0; k < 6; ++k) counts[k] = groups[k];
    }
    if (PROBE == 15) {
        // As many groups as probe 14 wrote.
        atomicAdd(probed[at], gl_WorkGroupID.x + 1);
        return;
    }
    probed[at] = answer;
}
