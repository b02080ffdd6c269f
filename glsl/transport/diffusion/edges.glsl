// Single and double layer of a triangle by its edges, of the kernel g(s) = e^(-k s) / (4 pi s): Green's theorem, then
// Gauss-Legendre quadrature as in `dipole/form_factor/edge.glsl`. For a receiver at height h over the plane, s_m the
// least distance to the triangle where that is more than h, else h, and r the distance from the foot:
//   int e^(-k s)/s dA               = e^(-k s_m) sum R int q phi1 / (s + s_m) dt,
//   h int (1 + k s) e^(-k s)/s^3 dA = e^(-k s_m) h/s_m sum R int q (1 + k s_m phi1) / (s (s + s_m)) dt,
// with phi1 = (1 - e^(-k(s - s_m))) / (k (s - s_m)) and q = (r^2 - r_m^2) / r^2. One value a channel.
#include "dipole/form_factor/edge.glsl"

// Adds both integrals over a part of one edge, without their factors.
void add_part(inout vec3 single, inout vec3 twice, vec3 k, float R, float t1, float t2, float h, float rim, float s_m) {
    float R2 = R * R, S = sqrt(R2 + h * h);
    float w1 = t1 / (S + sqrt(S * S + t1 * t1)), w2 = t2 / (S + sqrt(S * S + t2 * t2));
    float middle = 0.5 * (w1 + w2), half_width = 0.5 * (w2 - w1);
    bool outside = h < rim;
    vec3 of_single = vec3(0), of_double = vec3(0);
    for (uint i = 0; i < NODES; ++i) {
        float w = middle + half_width * node_at(i);
        float ratio = 1.0 / max((1.0 - w) * (1.0 + w), LEAST_GAP);
        float s = S * (1.0 + w * w) * ratio, t = 2.0 * S * w * ratio;
        float r2 = R2 + t * t, past = max(0.0, r2 - rim * rim);
        float q = outside ? past / max(r2, 1e-37) : 1.0;
        float beyond = (outside ? past : r2) / max(s + s_m, 1e-30);
        vec3 phi = phi1(k * beyond);
        float common_part = weight_at(i) * ratio * q / max(s + s_m, 1e-30);
        of_single += common_part * s * phi;
        of_double += common_part * (1.0 + k * s_m * phi);
    }
    single += 2.0 * R * half_width * of_single;
    twice += 2.0 * R * half_width * of_double;
}

// The inverse of sinh. Vulkan promises log(x + sqrt(x^2 + 1)) for the built-in one, which cancels for negative numbers.
// Numbers that are clamped give an edge the most parts anyway.
vec3 odd_asinh(vec3 x) {
    vec3 size = min(abs(x), vec3(1e18));
    return sign(x) * log(size + sqrt(size * size + 1.0));
}

// Adds both integrals over one edge; an elongated triangle's edges are taken in parts of even width in asinh(t / S).
void add_edge(inout vec3 single, inout vec3 twice, vec3 k, float R, float t1, float t2, float h, float rim, float s_m,
              bool elongated) {
    float S = sqrt(R * R + h * h);
    // An edge whose line meets the foot adds nothing.
    if (!(R * R > 0.0)) return;
    vec3 u = elongated ? odd_asinh(vec3(t1, t2, 0) / S) : vec3(0);
    float u1 = u.x, u2 = u.y;
    float parts = clamp(ceil((u2 - u1) / PART_WIDTH), 1.0, 8.0), from = t1;
    for (float part = 1.0; part <= parts; ++part) {
        float to = part < parts ? S * sinh(u1 + (u2 - u1) * part / parts) : t2;
        add_part(single, twice, k, R, from, to, h, rim, s_m);
        from = to;
    }
}

// Both layers of the triangle a b c (relative to the receiver), whose unit normal is `normal`; `height` is the
// receiver's height over the plane, 0 for the triangle itself.
void layers_of_triangle(vec3 k, vec3 a, vec3 b, vec3 c, uvec3 id, vec3 normal, float height,
                        out vec3 single, out vec3 twice) {
    vec3 foot = -height * normal, p0 = a - foot, p1 = b - foot, p2 = c - foot;
    bool inside = dot(cross(p0, p1), normal) >= 0.0 && dot(cross(p1, p2), normal) >= 0.0 &&
                  dot(cross(p2, p0), normal) >= 0.0;
    float nearest = min(min(segment_distance(p0, p1), segment_distance(p1, p2)), segment_distance(p2, p0));
    float longest = max(max(dot(p1 - p0, p1 - p0), dot(p2 - p1, p2 - p1)), dot(p0 - p2, p0 - p2));
    bool elongated = longest > ELONGATED * length(cross(b - a, c - a));
    float h = abs(height), rim = inside ? 0.0 : nearest;
    float s_m = h < rim ? sqrt(h * h + rim * rim) : h;
    single = vec3(0);
    twice = vec3(0);
    // The corners are rotated: arrays indexed at run time would go through memory.
    for (uint e = 0; e < 3; ++e) {
        bool swapped = id.x > id.y;
        vec3 p = swapped ? p1 : p0, q = swapped ? p0 : p1;
        float size = length(q - p);
        vec3 u = size > 0.0 ? (q - p) / size : vec3(0);
        float R = dot(cross(p, u), normal);
        vec3 one = vec3(0), two = vec3(0);
        add_edge(one, two, k, R, dot(p, u), dot(q, u), h, rim, s_m, elongated);
        single += swapped ? -one : one;
        twice += swapped ? -two : two;
        vec3 first = p0;
        p0 = p1;
        p1 = p2;
        p2 = first;
        id = id.yzx;
    }
    // Both integrands are positive; sums that cancel in a sliver may not be.
    vec3 fall = 0.0795774715 * exp(-k * s_m);
    single = fall * mix(single, vec3(0), lessThan(single, vec3(0)));
    twice = s_m > 0.0 ? fall * (height / s_m) * mix(twice, vec3(0), lessThan(twice, vec3(0))) : vec3(0);
}
