// What a group of `count` notes for `write`: for each block the place of one of its parts, or NONE; then the parts. A
// part has the place of another one of the block, or NONE, the number of its words, and these, sorted: each a node
// below its kind. All parts of a block but one have NOTED_LEAST words or more.
const uint WORDS = 512; // room for those of a part: one more than it has
