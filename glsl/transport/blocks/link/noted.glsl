// What a group of `count` notes for `write`: for each block the place of one of its parts, or NONE; then the parts. A part
// has the place of another one of the block, or NONE, the number of its words, and these, sorted: each a node below its
// kind. More than NOTED_LEAST of a block's words stand in each part but one.
const uint PART_HEADER = 2;
const uint WORDS = 512; // of a part at most
