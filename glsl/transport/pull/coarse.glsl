// From which distance on the coarse solution takes a cluster as one: chi = tau q2(sigma s) / (2 s^2) at its nearest
// point stays below 0.3, with q2(a) <= 15 + 5a + a^2; a channel counts up to sigma s = 20.
const float COARSE = 0.3;

float coarse_distance(vec3 diagonal, float radius) {
    float tau = max(diagonal.x + diagonal.y + diagonal.z, 1e-30);
    float farthest = 0.0;
    for (uint channel = 0; channel < 3; ++channel) {
        float sigma = frame[0].sigma[channel];
        float k = 2.0 * COARSE / tau - sigma * sigma;
        float s = k > 0.0 ? (5.0 * sigma + sqrt(25.0 * sigma * sigma + 60.0 * k)) / (2.0 * k) : 4.0;
        if (sigma > 0.0) s = min(s, 20.0 / sigma);
        farthest = max(farthest, min(s, 4.0));
    }
    return radius + farthest;
}
