// The form factor of a triangle by its three edges: Green's theorem, then Gauss-Legendre quadrature in w = tan(psi/2),
// where psi is the angle at the source between the foot of the edge and a point on it (equation 13 made free of
// cancellation). It needs only square root, division and exp, whose precision Vulkan bounds. Vectors run over channels.
// The includer has NODES: 3, 6 or 12. Divisors are at least 1e-37: a device may flush a denormal such as 1e-38.
// Nodes and weights come by selections: a table indexed at run time would be copied to each invocation's memory.

// The value of six for the nodes of one half, the outermost first.
float of_half(uint place, float a, float b, float c, float d, float e, float f) {
    return place == 0 ? a : place == 1 ? b : place == 2 ? c : place == 3 ? d : place == 4 ? e : f;
}

// Node number `k`, from -1 to 1.
float node_at(uint k) {
    uint place = min(k, NODES - 1 - k);
    float outer = NODES == 3 ? (place == 0 ? 0.774596669241 : 0.0)
                : NODES == 6 ? (place == 0 ? 0.932469514203 : place == 1 ? 0.661209386466 : 0.238619186083)
                : of_half(place, 0.981560634247, 0.904117256370, 0.769902674194, 0.587317954287, 0.367831498998,
                          0.125233408511);
    return 2 * k < NODES ? -outer : outer;
}

float weight_at(uint k) {
    uint place = min(k, NODES - 1 - k);
    return NODES == 3 ? (place == 0 ? 0.555555555556 : 0.888888888889)
         : NODES == 6 ? (place == 0 ? 0.171324492379 : place == 1 ? 0.360761573048 : 0.467913934573)
         : of_half(place, 0.047175336387, 0.106939325995, 0.160078328543, 0.203167426723, 0.233492536538,
                   0.249147045813);
}

// Half of the least value of (1 - w)(1 + w) for a w below 1 in f32. Where an edge points past the foot, w is 1 but for
// the rounding of a division, which differs between devices: a tiny difference of two such w must not count.
const float LEAST_GAP = 6e-8;

// (1 - e^{-x}) / x for x >= 0.
vec3 phi1(vec3 x) {
    vec3 series = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0))));
    return mix((1.0 - exp(-x)) / max(x, vec3(1e-3)), series, lessThan(x, vec3(0.1)));
}

// Distance from the origin of a plane to the segment p q.
float segment_distance(vec3 p, vec3 q) {
    vec3 along = q - p;
    float t = clamp(-dot(p, along) / max(dot(along, along), 1e-37), 0.0, 1.0);
    return length(p + t * along);
}

// Integral over one edge of the bracket of J, without the factor e^{-sigma s_m} / s_m. `rim` is the distance of the
// foot from the triangle, 0 inside; where it is below h it counts as 0: then s_m is h, and the 1/r^2 has cancelled.
vec3 edge_integral(vec3 sigma, float R, float t1, float t2, vec3 h, float rim, vec3 s_m) {
    float R2 = R * R;
    vec3 S = sqrt(R2 + h * h);
    vec3 w1 = t1 / (S + sqrt(S * S + t1 * t1)), w2 = t2 / (S + sqrt(S * S + t2 * t2));
    vec3 middle = 0.5 * (w1 + w2), half_width = 0.5 * (w2 - w1);
    bvec3 outside = lessThan(h, vec3(rim));
    vec3 sum = vec3(0);
    for (uint k = 0; k < NODES; ++k) {
        vec3 w = middle + half_width * node_at(k);
        vec3 ratio = 1.0 / max((1.0 - w) * (1.0 + w), LEAST_GAP);
        vec3 s = S * (1.0 + w * w) * ratio;
        vec3 t = 2.0 * S * w * ratio;
        vec3 r2 = R2 + t * t;
        vec3 past = max(vec3(0), r2 - rim * rim);
        vec3 q = mix(vec3(1), past / max(r2, vec3(1e-37)), outside);
        vec3 beyond = mix(r2, past, outside) / (s + s_m);
        sum += weight_at(k) * ratio * q * (1.0 + sigma * s_m * phi1(sigma * beyond)) / (s + s_m);
    }
    return 2.0 * R * half_width * sum;
}

// J = integral of (1 + sigma s) e^{-sigma s} / s^3 over the triangle a b c (relative to the receiver), for a source at
// height h over its plane, whose foot is `foot`. Each edge runs from the lower to the higher vertex number, so that
// the two triangles that share it compute the very same value.
vec3 edge_form(vec3 sigma, vec3 a, vec3 b, vec3 c, uvec3 id, vec3 normal, vec3 foot, vec3 h) {
    a -= foot;
    b -= foot;
    c -= foot;
    bool inside = dot(cross(a, b), normal) >= 0.0 && dot(cross(b, c), normal) >= 0.0 && dot(cross(c, a), normal) >= 0.0;
    float nearest = min(min(segment_distance(a, b), segment_distance(b, c)), segment_distance(c, a));
    float rim = inside ? 0.0 : nearest;
    vec3 s_m = mix(h, sqrt(h * h + rim * rim), lessThan(h, vec3(rim)));
    vec3 sum = vec3(0);
    // The corners are rotated, so that one copy of the code serves all edges: it takes long to compile.
    for (uint e = 0; e < 3; ++e) {
        bool swapped = id.x > id.y;
        vec3 p = swapped ? b : a, q = swapped ? a : b;
        float size = length(q - p);
        vec3 u = size > 0.0 ? (q - p) / size : vec3(0);
        float R = dot(cross(p, u), normal);
        vec3 value = edge_integral(sigma, R, dot(p, u), dot(q, u), h, rim, s_m);
        sum += swapped ? -value : value;
        vec3 first = a;
        a = b;
        b = c;
        c = first;
        id = id.yzx;
    }
    // The integrand is positive. Where the edges of a sliver cancel to less than their rounding, the sum may not be:
    // then 0 is nearest to the truth. (No max(): it may turn NaN into 0.)
    sum = mix(sum, vec3(0), lessThan(sum, vec3(0)));
    return exp(-sigma * s_m) / s_m * sum;
}
