#version 460

// Whether the device executes what it is given: each word after the first becomes a function of the first, which the
// host writes together with poison for the others.
layout(local_size_x = 64) in;
layout(set = 0, binding = 0) restrict buffer words_block { uint words[]; };

void main() {
    uint place = gl_LocalInvocationIndex + 1;
    if (place < words.length()) words[place] = (words[0] ^ place) * 2654435761u;
}
