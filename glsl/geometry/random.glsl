// Random numbers and directions about an axis: the same bits on every device.

// Four random integers from four integers: pcg4d of Jarzynski and Olano 2020.
uvec4 random4(uint a, uint b, uint c, uint d) {
    uvec4 v = uvec4(a, b, c, d) * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    return v;
}

// One of 2^23 numbers in (0, 1).
float unit_random(uint bits) {
    precise float x = float((bits >> 9) * 2u + 1u) * (1.0 / 16777216.0);
    return x;
}

// Two unit vectors across an axis and across each other (Duff et al. 2017).
void across_axis(vec3 axis, out vec3 right, out vec3 up) {
    float s = axis.z >= 0.0 ? 1.0 : -1.0;
    precise float a = -s * inverse_of(1.0 + s * axis.z);
    precise float b = axis.x * axis.y * a;
    precise vec3 first = vec3(1.0 + s * axis.x * axis.x * a, s * b, -s * axis.x);
    precise vec3 second = vec3(b, s + axis.y * axis.y * a, -axis.y);
    right = first;
    up = second;
}

// The direction with this cosine to an axis and this azimuth (in turns) about it.
vec3 about(vec3 axis, float cosine, float turns) {
    vec3 right, up;
    across_axis(axis, right, up);
    precise float square = 1.0 - cosine * cosine;
    float across = root_of(square);
    vec2 sc = turn(turns);
    precise vec3 way = cosine * axis + across * (sc.y * right + sc.x * up);
    return way;
}
