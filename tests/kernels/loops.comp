#version 460
#extension GL_EXT_scalar_block_layout : require

// One search, written four ways: 64 columns of `rows` numbers each; an invocation walks its column, by three rows where
// one of the two lowest bits of a number is set, else by one, and stops at every number whose third bit is set, too.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SHAPE = 0;
layout(set = 0, binding = 0, scalar) restrict readonly buffer numbers_block { uint rows; uint numbers[]; };
layout(set = 0, binding = 1, scalar) restrict writeonly buffer sums_block { uint sums[]; };

const uint NONE = 0xffffffffu;

uint number(uint row) {
    return numbers[row * 64 + gl_LocalInvocationIndex];
}

uint worth(uint row) {
    return (number(row) & 4) != 0 ? row * 7 + 1 : 1000000;
}

// 0: the inner loop assigns `hit` whether or not the lane goes on, and `hit` indexes a buffer after the loop.
uint unconditional() {
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
        if (found) sum += worth(hit);
    }
    return sum;
}

// 1: the inner loop changes what outlives it under a condition only, as in glsl/transport/brute/near.comp.
uint sentinel() {
    uint i = 0, sum = 0;
    while (i < rows) {
        uint hit = NONE;
        while (hit == NONE && i < rows) {
            uint r = number(i);
            bool far = (r & 3) != 0, stop = far && (r & 4) != 0;
            if (stop) hit = i;
            if (!stop) i += far ? 3 : 1;
        }
        if (hit != NONE) {
            sum += worth(hit);
            i = hit + 3;
        }
    }
    return sum;
}

// 2: one loop, as in every walk of a tree.
uint flat_loop() {
    uint i = 0, sum = 0;
    while (i < rows) {
        uint r = number(i);
        bool far = (r & 3) != 0;
        if (far && (r & 4) != 0) sum += worth(i);
        i += far ? 3 : 1;
    }
    return sum;
}

// 3: an inner loop that every lane runs equally often, as over the samples of a triangle.
uint counted() {
    uint i = 0, sum = 0;
    while (i < rows) {
        uint hit = NONE, next = i;
        for (uint k = 0; k < 4; ++k) {
            uint r = number(min(next, rows - 1));
            bool far = (r & 3) != 0, open = hit == NONE && next < rows;
            hit = open && far && (r & 4) != 0 ? next : hit;
            next += open ? (far ? 3 : 1) : 0;
        }
        if (hit != NONE) sum += worth(hit);
        i = next;
    }
    return sum;
}

void main() {
    uint sum = 0;
    if (SHAPE == 0) sum = unconditional();
    if (SHAPE == 1) sum = sentinel();
    if (SHAPE == 2) sum = flat_loop();
    if (SHAPE == 3) sum = counted();
    sums[gl_LocalInvocationIndex] = sum;
}
