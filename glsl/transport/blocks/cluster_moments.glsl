// A cluster's light: its sum, centroid and second moments. The includer reads `moments` and `second_moments`.
struct ClusterMoments { vec3 center; float weight; vec3 diagonal; vec3 mixed; };

ClusterMoments cluster_moments(uint node) {
    Moment m = moments[node];
    SecondMoments s = second_moments[node];
    return ClusterMoments(m.center, m.weight, s.diagonal, s.mixed);
}
