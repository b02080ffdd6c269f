// BLOCK_RECEIVERS receivers a block, of which the last ones may be absent; one invocation each, or one of each team.
struct Receiver { uint run; uint face; bool present; vec3 x; };

// The includer reads blocks and places, and has `range`.
Receiver receiver_of(uint run, uint place, bool present) {
    Block block = blocks[range.first + run];
    uint slot = place % BLOCK_RECEIVERS;
    uint face = block.first + min(slot, block.count - 1);
    return Receiver(run, face, present && slot < block.count, receiver_positions[face]);
}

Receiver receiver_at(uint place) {
    return receiver_of(min(place / BLOCK_RECEIVERS, range.count - 1), place, place / BLOCK_RECEIVERS < range.count);
}
