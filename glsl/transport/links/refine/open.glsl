// Starts a chunk with empty lists; handed-down emitters of the tree's top stay where they are.
layout(push_constant, scalar) uniform push_block { uint chunk; };
UPDATES(counters)

void main() {
    if (invocation() != 0) return;
    if (chunk == 0) {
        ListCounters old = counters[0];
        counters[0] = ListCounters(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, old.contrast, old.contrast, 0, 0, 0, 0, 0, 0, 0, 0,
            old.padding, old.more_padding, 0);
    }
    counters[0].links = 0;
    counters[0].areas = 0;
    counters[0].edges = 0;
    counters[0].hands = counters[0].kept;
}
