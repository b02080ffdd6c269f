// All invocations of the group walk the tree at once, or, where the words are too many for the pool, part by part.

// What the includer does after the first walk, with room for all words or not, ...
void on_first(bool cut);
// ... and with the sorted words of each part. It returns whether it wants more.
bool on_part(uint total);

// Tries so many nodes first. Returns false where even a part of one node does not fit: the tree is too deep, or the
// driver cuts walks short.
bool walk_by_parts(uint size) {
    uint begin = 0, nodes = object_params[0].nodes;
    bool more = true, first_walk = true;
    while (more && begin < nodes && size > 0) {
        uint end = min(begin + size, nodes);
        bool cut, fits = walk_part(begin, end, cut);
        if (first_walk) on_first(cut);
        first_walk = false;
        if (fits) {
            uint total = found_count;
            sort_found(total);
            more = total == 0 || on_part(total);
            begin = end;
            size = min(2 * size, nodes);
        } else {
            size /= 2;
        }
        barrier();
    }
    return size > 0;
}
