// A cluster's light: its sum, centroid and second moments. The includer reads `moments` and `spreads`.
struct Cloud { vec3 center; float weight; vec3 diagonal; vec3 mixed; };

Cloud cloud_of(uint node) {
    Moment m = moments[node];
    Spread s = spreads[node];
    return Cloud(m.center, m.weight, s.diagonal, s.mixed);
}
