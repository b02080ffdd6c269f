// How a link's form factor is evaluated. The includer reads `object_params`; d2 is a distance by `dipole/near.glsl`.
READS(reach)
READS(cluster_reach)

// The cheapest evaluation that serves at this distance.
uint rule_of(float d2, vec4 radii) {
    if (d2 >= radii.x) return RULE_SAMPLE;
    return d2 >= min(radii.y, min(radii.z, radii.w)) ? RULE_AREA : RULE_EDGE;
}

// The same for a cluster: over its projection where the receiver is nearer than the cluster's reach.
uint cluster_rule(float d2, uint node) {
    bool near = object_params[0].projected != 0 && d2 < cluster_reach[node];
    return near ? RULE_EDGE : RULE_SAMPLE;
}

uint rule_of(float d2, uint node, uint face) {
    return face == NONE ? cluster_rule(d2, node) : rule_of(d2, reach[min(face, object_params[0].faces - 1)]);
}
