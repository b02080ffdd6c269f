// What a group of `count` notes for `write`: for each block the place of its last part, or NONE; then the parts. A
// part has the place of the block's part before it, which is lower, or NONE, the number of its words, and these,
// sorted: each a node below its kind. All parts of a block but the last have NOTED_LEAST words or more.
const uint WORDS = 512; // room for those of a part: one more than it has
