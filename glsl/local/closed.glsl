// The curvature-dependent reflectance function in closed form: max(cos, 0) over the circle, convolved with a Gaussian of
// standard deviation sigma. Within 5e-6.

// The arcsine of a number from -1 to 1, and its cosine; within 1e-7 (Abramowitz and Stegun 4.4.46).
float arcsine(float s, out float cosine) {
    float m = min(abs(s), 1.0);
    float p = -0.0012624911;
    p = p * m + 0.0066700901;
    p = p * m - 0.0170881256;
    p = p * m + 0.0308918810;
    p = p * m - 0.0501743046;
    p = p * m + 0.0889789874;
    p = p * m - 0.2145988016;
    p = p * m + 1.5707963050;
    float root = sqrt(1.0 - m);
    cosine = root * sqrt(1.0 + m);
    float a = 1.5707963268 - root * p;
    return s < 0.0 ? -a : a;
}

vec3 cdrf(float c, vec3 sigma) {
    c = clamp(c, -1.0, 1.0);
    vec3 s = clamp(sigma, vec3(1e-5), vec3(8.0)), s2 = s * s, e = exp(-0.5 * s2);

    // A wide Gaussian: 1 / pi + e^(-s^2/2) cos / 2 + 2 / pi times the sum of (-1)^(n+1) / (4 n^2 - 1) e^(-2 n^2 s^2) cos 2 n t.
    vec3 q = e * e;
    q *= q;
    float twice = 4.0 * c * c - 2.0, before = 1.0, even = 0.5 * twice, sign = 1.0;
    vec3 q2 = q * q, power = q, factor = q2 * q, wide = 0.5 + 0.78539816339745 * e * c;
    for (int n = 1; n <= 5; ++n) {
        wide += sign / float(4 * n * n - 1) * even * power;
        power *= factor;
        factor *= q2;
        float next = twice * even - before;
        before = even;
        even = next;
        sign = -sign;
    }
    wide *= 0.63661977236758;

    // A narrow one: the edge of the lit half at a distance x, in standard deviations X; Phi by 26.2.17.
    float cosine, x = arcsine(c, cosine);
    vec3 X = x / s, X2 = X * X, phi = 0.39894228040143 * exp(-0.5 * X2);
    vec3 t = 1.0 / (1.0 + 0.2316419 * abs(X));
    vec3 tail = phi * t * (0.319381530 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    vec3 Phi = mix(1.0 - tail, tail, lessThan(X, vec3(0)));
    vec3 C = e * Phi + phi * s2 * X * (0.5 - s2 * (X2 + 3.0) / 24.0);
    vec3 S = phi * s * (-1.0 + s2 * ((X2 + 2.0) / 6.0 - s2 * (X2 * X2 + 4.0 * X2 + 8.0) / 120.0));
    return max(vec3(0), mix(c * C - cosine * S, wide, greaterThanEqual(s, vec3(0.32))));
}
