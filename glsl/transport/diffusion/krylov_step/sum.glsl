// The sum over a work group of one value each; the includer declares the size of its group.
shared vec3 partial[GROUP_SIZE];

vec3 sum_of_group(vec3 value) {
    uint self = gl_LocalInvocationIndex;
    partial[self] = value;
    for (uint half_count = GROUP_SIZE / 2; half_count > 0; half_count /= 2) {
        barrier();
        if (self < half_count) partial[self] += partial[self + half_count];
    }
    barrier();
    return partial[0];
}
