// The vector area of a triangle, as accurate as single precision allows for a thin one. The cross product of its two
// shorter edges cancels least. The remaining rounding tilts the vector, most along the longest edge, which reaches far
// from the centre, so that the plane would miss points of the triangle. That edge is known more accurately: the vector
// is made perpendicular to it.
vec3 vector_area(vec3 a, vec3 b, vec3 c) {
    vec3 e0 = b - a, e1 = c - b, e2 = a - c;
    float s0 = dot(e0, e0), s1 = dot(e1, e1), s2 = dot(e2, e2), most = max(s0, max(s1, s2));
    vec3 longest = s0 == most ? e0 : s1 == most ? e1 : e2;
    vec3 area = 0.5 * (s0 == most ? cross(e1, e2) : s1 == most ? cross(e2, e0) : cross(e0, e1));
    return most > 0.0 ? area - longest * (dot(area, longest) / most) : area;
}
