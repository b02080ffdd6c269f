// The single layer of a triangle by its edges, at its own depth in each channel; the integrals are those of
// `edges.glsl`. All vectors run over the channels, but for places and the normal.

// Adds the integral over a part of one edge, without its factors.
void add_part_of_source(inout vec3 sum, vec3 k, vec3 R, vec3 t1, vec3 t2, vec3 h, vec3 rim, vec3 s_m) {
    vec3 R2 = R * R, S = sqrt(R2 + h * h);
    vec3 w1 = t1 / max(S + sqrt(S * S + t1 * t1), 1e-30), w2 = t2 / max(S + sqrt(S * S + t2 * t2), 1e-30);
    vec3 middle = 0.5 * (w1 + w2), half_width = 0.5 * (w2 - w1), part = vec3(0);
    bvec3 outside = lessThan(h, rim);
    for (uint i = 0; i < NODES; ++i) {
        vec3 w = middle + half_width * node_at(i);
        vec3 ratio = 1.0 / max((1.0 - w) * (1.0 + w), LEAST_GAP);
        vec3 s = S * (1.0 + w * w) * ratio, t = 2.0 * S * w * ratio;
        vec3 r2 = R2 + t * t, past = mix(r2, max(vec3(0), r2 - rim * rim), outside);
        vec3 q = mix(vec3(1), past / max(r2, 1e-37), outside), both = max(s + s_m, 1e-30);
        part += weight_at(i) * ratio * q * s / both * phi1(k * past / both);
    }
    sum += mix(2.0 * R * half_width * part, vec3(0), lessThanEqual(R2, vec3(0)));
}

vec3 dot_each(vec3 each[3], vec3 way) { return vec3(dot(each[0], way), dot(each[1], way), dot(each[2], way)); }

// The triangle's corners and its middle are relative to the receiver; `depth` shifts them in each channel.
vec3 single_at_depths(vec3 k, vec3 corner[3], vec3 middle, vec3 depth[3], vec3 normal) {
    vec3 height = -(dot(middle, normal) + dot_each(depth, normal));
    vec3 moved[3] = vec3[3](depth[0] + height.x * normal, depth[1] + height.y * normal, depth[2] + height.z * normal);
    vec3 R[3], t[3];
    float size[3], longest = 0.0;
    vec3 rim2 = vec3(1e30);
    bvec3 inside = bvec3(true);
    for (uint e = 0; e < 3; ++e) {
        vec3 p = corner[e], side = corner[(e + 1) % 3] - p;
        size[e] = length(side);
        vec3 u = size[e] > 0.0 ? side / size[e] : vec3(0), out_of = cross(u, normal);
        R[e] = dot(p, out_of) + dot_each(moved, out_of);
        t[e] = dot(p, u) + dot_each(moved, u);
        vec3 past = max(max(t[e], -(t[e] + size[e])), vec3(0));
        rim2 = min(rim2, R[e] * R[e] + past * past);
        inside = bvec3(inside.x && R[e].x >= 0.0, inside.y && R[e].y >= 0.0, inside.z && R[e].z >= 0.0);
        longest = max(longest, size[e]);
    }
    bool elongated = longest * longest > ELONGATED * length(cross(corner[1] - corner[0], corner[2] - corner[0]));
    vec3 h = abs(height), rim = mix(sqrt(rim2), vec3(0), inside);
    vec3 s_m = mix(h, sqrt(h * h + rim * rim), lessThan(h, rim)), sum = vec3(0);
    for (uint e = 0; e < 3; ++e) {
        vec3 from = t[e], end = t[e] + size[e], S = max(sqrt(R[e] * R[e] + h * h), vec3(1e-30));
        vec3 u1 = elongated ? odd_asinh(from / S) : vec3(0), u2 = elongated ? odd_asinh(end / S) : vec3(0);
        float widest = max(max(u2.x - u1.x, u2.y - u1.y), u2.z - u1.z);
        float parts = clamp(ceil(widest / PART_WIDTH), 1.0, 8.0);
        for (float part = 1.0; part <= parts; ++part) {
            vec3 to = part < parts ? S * sinh(u1 + (u2 - u1) * (part / parts)) : end;
            add_part_of_source(sum, k, R[e], from, to, h, rim, s_m);
            from = to;
        }
    }
    return 0.0795774715 * exp(-k * s_m) * max(sum, vec3(0));
}
