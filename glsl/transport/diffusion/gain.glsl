// The gain that errors of clusters count relative to: what the integral operator makes of even light on a ball of this
// area, the least over the channels: 1/2 + D + S/z_b with x = k R, S = R phi1(2x), phi1(x) = (1 - e^-x)/x,
// D = (e^-2x - 2 phi1(2x))/2. It is divided by GAIN_OF_ONE and clamped to LEAST_GAIN to 1.
float layer_gain(float area) {
    float radius = sqrt(area * 0.0795774715), least = 1e30;
    for (uint c = 0; c < 3; ++c) {
        float x = object_params[0].sigma[c] * radius, fall = exp(-2.0 * x);
        float phi = x < 1e-3 ? 1.0 - x : (1.0 - fall) / (2.0 * x);
        float whole = x < 0.3 ? x * x * (1.0 - x + 0.6 * x * x) / 3.0 : 0.5 * (1.0 + fall) - phi;
        least = min(least, whole + radius * phi / object_params[0].boundary[c]);
    }
    return clamp(least / GAIN_OF_ONE, LEAST_GAIN, 1.0);
}
