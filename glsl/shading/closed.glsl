// The curvature-dependent reflectance function in closed form: max(cos, 0) over the circle, convolved with a Gaussian
// of standard deviation sigma, within 6e-6. It is half of the blurred cosine plus half of the blurred |cos|, a function
// of c^2.
vec3 cdrf(float c, vec3 sigma) {
    c = clamp(c, -1.0, 1.0);
    vec3 s = clamp(sigma, vec3(1e-5), vec3(8.0)), s2 = s * s, e = exp2(-0.72134752 * s2);

    // A wide Gaussian: 1 / pi + 2 / pi times the sum of (-1)^(n+1) / (4 n^2 - 1) q^(n^2) cos 2 n t, q = e^(-2 s^2).
    vec3 q = e * e;
    q *= q;
    vec3 q2 = q * q, q3 = q2 * q, q5 = q3 * q2, q7 = q5 * q2, q9 = q7 * q2;
    float m = c * c, once = 2.0 * m - 1.0, twice = 2.0 * once;
    float second = twice * once - 1.0, third = twice * second - once, fourth = twice * third - second;
    vec3 wide = 0.01010508 * fourth - q9 * (0.00643050 * (twice * fourth - third));
    wide = 0.04244132 * second - q5 * (0.01818914 * third - q7 * wide);
    wide = 0.31830989 + q * (0.21220659 * once - q3 * wide);

    // A narrow one: e |c| / 2, and near the edge of the lit half s times a Gaussian of x / s, x the angle from the
    // edge, times a polynomial in s^2 and t, fitted to the convolution; t falls from 1 at the edge to 0 far from it.
    // x^2 is a polynomial in c^2.
    float a = abs(c), x2 = m * (1.0 + m * (0.32401063 + m * (0.28757736 + m * (-0.28045327 + m * 0.55516601))));
    vec3 t = s / (s + 0.4 * a);
    vec3 near = -0.05878687 + t * (0.39388367 + t * (-0.94191491 + t * (1.28325265 - t * 0.27757759)));
    vec3 next = -0.05288886 + t * (-1.15860064 + t * (3.83628634 + t * (-3.89836145 + t * 1.14393675)));
    vec3 narrow = 0.5 * a * e + s * exp2(-0.72134752 * x2 / s2) * (near + s2 * next);
    return max(vec3(0), 0.5 * c * e + mix(narrow, wide, greaterThanEqual(s, vec3(0.32))));
}
