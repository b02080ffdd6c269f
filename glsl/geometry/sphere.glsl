// The sphere around some receivers: the middle of their box, and the distance of the farthest. The includer reads
// `receiver_positions`, `clusters` and `object_params`.
Sphere sphere_of(uint first, uint count) {
    vec3 low = vec3(1e30), high = vec3(-1e30);
    for (uint k = 0; k < count; ++k) {
        vec3 x = receiver_positions[first + k];
        low = min(low, x);
        high = max(high, x);
    }
    vec3 center = 0.5 * (low + high);
    float radius2 = 0.0, spread = 0.0;
    for (uint k = 0; k < count; ++k) {
        vec3 d = receiver_positions[first + k] - center;
        radius2 = max(radius2, dot(d, d));
        spread += dot(d, d);
    }
    // The mean square radius of the usual block: a flat disc of the mean area of all blocks.
    float disc = max(clusters[0].area / (6.2831853 * float(object_params[0].usual_blocks)), 1e-30);
    return Sphere(center, sqrt(radius2), spread / (float(count) * disc));
}
