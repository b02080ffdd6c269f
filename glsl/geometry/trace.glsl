// The nearest triangle along a ray, by the tree. Decisions: additions, multiplications and comparisons only.
//
// A triangle is hit when the three signed volumes of the ray with its edges agree in sign, edges included, so that
// no ray slips between two triangles. Distances are fractions and are compared across; nothing is divided.

// In place of a triangle where the driver has cut the walk short (lavapipe: after 65,535 iterations).
const uint UNFINISHED = 0xfffffffeu;

struct Nearest {
    uint face;        // or NONE, or UNFINISHED
    vec3 weights;     // signed volumes of the three edges; barycentric once divided by their sum
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

// Whether the half line may meet the box before the nearest hit: separating axes, with a margin above rounding.
bool meets(vec3 low, vec3 high, vec3 origin, vec3 direction, float dd, Nearest nearest) {
    precise vec3 c = 0.5 * (low + high) - origin;
    precise float margin = 1e-6 * (1.0 + abs(c.x) + abs(c.y) + abs(c.z));
    precise vec3 h = 0.5 * (high - low) * 1.00001 + margin;
    precise vec3 d = abs(direction);
    vec3 side = abs(cross3(c, direction));
    precise vec3 reach = vec3(h.y * d.z + h.z * d.y, h.z * d.x + h.x * d.z, h.x * d.y + h.y * d.x);
    bool line = side.x <= reach.x && side.y <= reach.y && side.z <= reach.z;
    float along = dot3(c, direction), half_length = dot3(h, d);
    precise float last = along + half_length;
    precise float first = (along - half_length) * nearest.denominator;
    precise float limit = nearest.numerator * dd;
    return line && last >= 0.0 && (nearest.face == NONE || first <= limit);
}

Nearest trace(vec3 origin, vec3 direction) {
    Nearest nearest = Nearest(NONE, vec3(0), 0.0, 1.0);
    float dd = dot3(direction, direction);
    uint node = 0, end = frame[0].scene_nodes;
    while (node < end) {
        Bounds box = bounds[node];
        bool met = meets(box.low, box.high, origin, direction, dd, nearest), leaf = box.face != NONE;
        if (met && leaf) {
            uvec3 corner = triangles[box.face];
            precise vec3 a = positions[corner.x] - origin;
            precise vec3 b = positions[corner.y] - origin;
            precise vec3 c = positions[corner.z] - origin;
            vec3 w = vec3(dot3(direction, cross3(b, c)), dot3(direction, cross3(c, a)), dot3(direction, cross3(a, b)));
            precise vec3 e1 = b - a;
            precise vec3 e2 = c - a;
            vec3 normal = cross3(e1, e2);
            float numerator = dot3(a, normal), denominator = dot3(direction, normal);
            bool front = w.x >= 0.0 && w.y >= 0.0 && w.z >= 0.0;
            bool back = w.x <= 0.0 && w.y <= 0.0 && w.z <= 0.0;
            if (denominator < 0.0) {
                numerator = -numerator;
                denominator = -denominator;
            }
            precise float mine = numerator * nearest.denominator;
            precise float its = nearest.numerator * denominator;
            bool nearer = nearest.face == NONE || mine < its || (mine == its && box.face < nearest.face);
            precise float sum = w.x + w.y + w.z;
            if ((front || back) && sum != 0.0 && denominator > 0.0 && numerator > 0.0 && nearer)
                nearest = Nearest(box.face, w, numerator, denominator);
        }
        node = met && !leaf ? node + 1 : box.next;
    }
    if (node < end) nearest.face = UNFINISHED;
    return nearest;
}
