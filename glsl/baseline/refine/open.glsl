// Starts a chunk: its lists are empty; handed-down emitters of the tree's top stay where they are.
layout(push_constant, scalar) uniform push_block { uint chunk; };
UPDATES(cursor)

void main() {
    if (invocation() != 0) return;
    if (chunk == 0) {
        Cursor old = cursor[0];
        cursor[0] = Cursor(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, old.contrast, old.contrast, 0, 0, 0, 0, 0, 0, 0, 0,
            old.padding, old.more_padding, old.last_padding);
    }
    cursor[0].links = 0;
    cursor[0].areas = 0;
    cursor[0].edges = 0;
    cursor[0].hands = cursor[0].kept;
}
