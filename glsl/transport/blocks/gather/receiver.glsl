// A block has BLOCK_RECEIVERS receivers, the last of which may be absent; each has one invocation, or one of each team.
struct Receiver { uint run; uint face; bool present; vec3 x; };

// The includer reads `blocks` and `receiver_positions`, and has `range`.
Receiver receiver_of(uint run, uint place, bool present) {
    Block block = blocks[range.first + run];
    uint slot = place % BLOCK_RECEIVERS;
    uint face = block.first + min(slot, block.count - 1);
    return Receiver(run, face, present && slot < block.count, receiver_positions[face]);
}

Receiver receiver_at(uint place) {
    return receiver_of(min(place / BLOCK_RECEIVERS, range.count - 1), place, place / BLOCK_RECEIVERS < range.count);
}
