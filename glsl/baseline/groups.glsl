// Groups to dispatch for so many elements, in rows as `invocation` has them.
const uint ROW = 32768, GROUP = 64;

uvec3 groups(uint count) {
    uint needed = (count + GROUP - 1) / GROUP;
    return uvec3(min(needed, ROW), (needed + ROW - 1) / ROW, 1);
}
