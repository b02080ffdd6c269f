// A ray against boxes and triangles. Decisions: additions, multiplications and comparisons only.
//
// A triangle is hit when the point where the ray pierces its plane lies on the same side of its three edges, edges
// included. Sides are found across the ray: each corner's place on two axes there is rounded once, the same for all
// triangles around it, and the sign of a difference of two products of such places is never wrong, zero at most. So no
// ray slips between two triangles, nor past a corner that many share. Distances are fractions, compared across; nothing
// is divided.

struct Nearest {
    uint face;        // or NONE, or UNFINISHED
    vec3 weights;     // sides of the three edges; barycentric once divided by their sum
    float numerator;  // distance along the ray = numerator / denominator, denominator > 0
    float denominator;
};

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

vec3 cross3(vec3 a, vec3 b) {
    precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return c;
}

// A ray's direction times a power of two, so that its largest part is 1 to 2; two axes across it; and that power.
struct Sight {
    vec3 along, right, up;
    float scale;
    float square; // of the length of `along`
};

Sight sight(vec3 direction) {
    vec3 m = abs(direction);
    float scale = uintBitsToFloat(0x7f000000u - (floatBitsToUint(max(m.x, max(m.y, m.z))) & 0x7f800000u));
    precise vec3 d = scale * direction;
    vec3 right = vec3(d.z, 0, -d.x), up = vec3(0, d.z, -d.y);
    if (m.z < max(m.x, m.y)) {
        right = vec3(-d.y, d.x, 0);
        up = m.x >= m.y ? vec3(-d.z, 0, d.x) : vec3(0, -d.z, d.y);
    }
    return Sight(d, right, up, scale, dot3(d, d));
}

// Where the ray pierces a triangle whose corners are relative to its origin: weights of the corners, all of one sign
// where it is hit, and the distance of that point: numerator / (denominator x square), in multiples of `along`.
Nearest pierce(Sight ray, vec3 a, vec3 b, vec3 c) {
    vec3 x = vec3(dot3(ray.right, a), dot3(ray.right, b), dot3(ray.right, c));
    vec3 y = vec3(dot3(ray.up, a), dot3(ray.up, b), dot3(ray.up, c));
    precise vec3 w = vec3(x.y * y.z - y.y * x.z, x.z * y.x - y.z * x.x, x.x * y.y - y.x * x.y);
    bool front = w.x >= 0.0 && w.y >= 0.0 && w.z >= 0.0;
    bool back = w.x <= 0.0 && w.y <= 0.0 && w.z <= 0.0;
    precise float sum = w.x + w.y + w.z;
    float away = dot3(w, vec3(dot3(ray.along, a), dot3(ray.along, b), dot3(ray.along, c)));
    bool hit = (front || back) && sum != 0.0;
    return Nearest(hit ? 0 : NONE, w, sum < 0.0 ? -away : away, abs(sum));
}

// Whether the half line may meet the box before the nearest hit: separating axes, with a margin above rounding.
bool meets(vec3 low, vec3 high, vec3 origin, Sight ray, Nearest nearest) {
    precise vec3 c = 0.5 * (low + high) - origin;
    precise float margin = 1e-6 * (1.0 + abs(c.x) + abs(c.y) + abs(c.z));
    precise vec3 h = 0.5 * (high - low) * 1.00001 + margin;
    precise vec3 d = abs(ray.along);
    vec3 side = abs(cross3(c, ray.along));
    precise vec3 reach = vec3(h.y * d.z + h.z * d.y, h.z * d.x + h.x * d.z, h.x * d.y + h.y * d.x);
    bool line = side.x <= reach.x && side.y <= reach.y && side.z <= reach.z;
    float along = dot3(c, ray.along), half_length = dot3(h, d);
    precise float last = along + half_length;
    precise float first = (along - half_length) * nearest.denominator;
    return line && last >= 0.0 && (nearest.face == NONE || first <= nearest.numerator);
}
