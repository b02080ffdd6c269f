// The node after a subtree among those of all objects: the last one's is the next object's first.
uint next_of(uint skip) { return skip == frame[0].nodes ? frame[0].next_node : frame[0].first_node + skip; }
