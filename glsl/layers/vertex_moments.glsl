// The moments of two clusters' vertices together.
VertexMoments joined(VertexMoments a, VertexMoments b) {
    float count = a.count + b.count, share = count > 0.0 ? b.count / count : 0.0;
    vec3 d = b.center - a.center;
    float weight = a.count * share;
    return VertexMoments(count, a.center + share * d, a.diagonal + b.diagonal + weight * d * d,
                 a.mixed + b.mixed + weight * d.yzx * d.zxy);
}
