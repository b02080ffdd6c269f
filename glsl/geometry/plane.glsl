// A triangle's plane, and on which side of it a point certainly lies. Additions, multiplications and comparisons only.

struct Plane {
    vec3 corner;
    vec3 normal; // its length is twice the triangle's area
    vec3 size;   // the same sums with every term positive: rounding is a share of it
};

Plane plane_of(vec3 a, vec3 b, vec3 c) {
    precise vec3 e1 = b - a;
    precise vec3 e2 = c - a;
    precise vec3 p = abs(e1), q = abs(e2);
    precise vec3 size = vec3(p.y * q.z + p.z * q.y, p.z * q.x + p.x * q.z, p.x * q.y + p.y * q.x);
    return Plane(a, cross3(e1, e2), size);
}

// Whether a point lies beyond the plane on the side that its normal points to (side 1) or the other (side -1), for
// certain: rounding changes the height by at most 8 x 2^-24 of its positive terms; twice that is required.
bool beyond(Plane plane, vec3 point, float side) {
    precise vec3 a = point - plane.corner;
    precise float height = side * dot3(a, plane.normal);
    precise float least = PLANE_ROUNDING * dot3(abs(a), plane.size);
    return height > least;
}
