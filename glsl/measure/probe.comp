#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "layout.glsl"

// What kernels rely on, and what some drivers get wrong: each probe has an exact answer, in whole words. Numbers come
// from a buffer, so that no compiler knows them.
layout(local_size_x = GROUP_SIZE) in;
layout(constant_id = 0) const uint PROBE = 0;

struct Uneven {
    float before;
    vec3 middle;
    float after;
};

// 64 columns of rows, after the number of rows.
layout(set = 0, binding = 0, scalar) restrict readonly buffer number_block { uint rows; uint numbers[]; };
layout(set = 0, binding = 1, scalar) restrict readonly buffer term_block { float terms[]; };
layout(set = 0, binding = 2, scalar) restrict readonly buffer uneven_block { Uneven uneven[]; };
layout(set = 0, binding = 3, scalar) restrict writeonly buffer answer_block { uint probed[]; };

shared uint parts[GROUP_SIZE];

uint number(uint row) {
    return numbers[row * GROUP_SIZE + gl_LocalInvocationIndex];
}

// Steps of three rows where a number has one of its two lowest bits, else of one; the inner loop assigns `hit` in
// every iteration, and `hit` indexes a buffer after it.
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

void main() {
    uint answer = 0;
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
    probed[gl_LocalInvocationIndex] = answer;
}
