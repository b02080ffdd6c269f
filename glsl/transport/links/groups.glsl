// Groups to dispatch for `count` elements, in rows, as `invocation` numbers them.
uvec3 groups(uint count) {
    uint needed = (count + GROUP_SIZE - 1) / GROUP_SIZE;
    return uvec3(min(needed, GROUPS_A_ROW), (needed + GROUPS_A_ROW - 1) / GROUPS_A_ROW, 1);
}
