#version 460
#extension GL_EXT_scalar_block_layout : require

// The same search with four loop structures. 64 columns of `rows` numbers; each invocation walks its column in steps of
// three rows where either of a number's two lowest bits is set, else of one row, and sums over such numbers whose third
// bit is set too.
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

// 0: the inner loop assigns `hit` in every iteration, and `hit` indexes a buffer after the loop.
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

// 1: the inner loop changes outer variables only under a condition, as in glsl/transport/brute/near.comp.
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

// 2: one flat loop, as in every tree traversal.
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

// 3: an inner loop with the same trip count in every lane, like a loop over the samples of a triangle.
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
