// Clusters from their children's: one level a dispatch, or, with CLIMBS, all levels at once. Then an invocation for
// each triangle climbs; of the two that arrive at a cluster the second, which finds the mark of the first and takes it
// away, goes on with it, since both its children are done. Which of them that is changes no bit. The includer SHARES
// what it writes, and reads `topology`.
#include "invocation.glsl"

layout(constant_id = CLIMBS_ID) const uint CLIMBS = 0;
layout(push_constant, scalar) uniform push_block { Range range; };
READS(order)
READS(leaves)
SHARES(arrivals)

// Makes a cluster; its left child is the next node.
void of_cluster(uint node, uint right);

void main() {
    uint i = invocation();
    if (i >= range.count) return;
    if (CLIMBS == 0) {
        uint node = order[range.first + i];
        of_cluster(node, topology[node + 1].skip);
        return;
    }
    // A node's parent and right child are loaded before its turn: these loads wait for no arrival.
    uint node = topology[leaves[i]].parent;
    if (node == NONE) return;
    uint parent = topology[node].parent, right = topology[node + 1].skip;
    for (;;) {
        memoryBarrierBuffer();
        if (atomicXor(arrivals[node], 1) == 0) return;
        memoryBarrierBuffer();
        uint next = parent == NONE ? 0 : parent;
        uint next_parent = topology[next].parent, next_right = topology[next + 1].skip;
        of_cluster(node, right);
        if (parent == NONE) return;
        node = parent;
        parent = next_parent;
        right = next_right;
    }
}
