// Walks whose words are too many for the pool go part by part through the tree, by all invocations of the group.

// What the includer does with the sorted words of a part. It returns whether it wants more.
bool on_part(uint total);

// Returns false where even a part of one node does not fit: the tree is too deep.
bool walk_by_parts() {
    uint begin = 0, nodes = object_params[0].nodes, size = (nodes + 1) / 2;
    bool more = true;
    while (more && begin < nodes && size > 0) {
        uint end = min(begin + size, nodes);
        bool cut;
        barrier();
        if (walk_part(begin, end, cut)) {
            uint total = found_count;
            sort_found(total);
            more = total == 0 || on_part(total);
            begin = end;
            size = min(2 * size, nodes);
        } else {
            size /= 2;
        }
    }
    return size > 0;
}
