// The integral over s from 0 to 1 of (a + (b - a) s) exp(-(from + (to - from) s)), where `start` = exp(-from),
// `end` = exp(-to) and d = to - from: a E0 + (b - a) E1 with E1 = ((start - end) / d - end) / d, or its series, and
// E0 = end + d E1.
vec3 segment(vec3 a, vec3 b, vec3 start, vec3 end, vec3 d) {
    vec3 series = 1.0 / 8.0 + d * (-1.0 / 30.0 + d * (1.0 / 144.0 - d * (1.0 / 840.0)));
    series = start * (1.0 / 2.0 + d * (-1.0 / 3.0 + d * series));
    bvec3 small = lessThan(abs(d), vec3(0.3));
    vec3 over = 1.0 / mix(d, vec3(1), small);
    vec3 e1 = mix(((start - end) * over - end) * over, series, small);
    return a * (end + d * e1) + (b - a) * e1;
}
