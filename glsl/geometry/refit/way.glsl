// The node after a subtree among those of all objects: the last one's is the next object's first.
uint next_of(uint skip) { return skip == object_params[0].nodes ? object_params[0].next_node : object_params[0].first_node + skip; }
