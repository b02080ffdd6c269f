// The cosine between the surface and the eye at which light leaves a point of a triangle. Interpolated normals turn
// edge-on before a coarse mesh ends, and no light leaves edge-on, which would draw a dark seam along the silhouette.
// So where the triangle itself is seen at a larger cosine, that counts, up to LEAST_SEEN. On a fine mesh both agree.
float seen_cosine(vec3 normal, vec3 eye, vec3 a, vec3 b, vec3 c) {
    precise vec3 e1 = b - a;
    precise vec3 e2 = c - a;
    precise vec3 plain = vec3(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
    float square = dot(eye, eye), own = abs(dot(normal, eye)) / sqrt(max(dot(normal, normal) * square, 1e-30));
    float size = max(abs(plain.x), max(abs(plain.y), abs(plain.z)));
    plain /= max(size, 1e-30);
    float whole = abs(dot(plain, eye)) / sqrt(max(dot(plain, plain) * square, 1e-30));
    return dot(normal, normal) > 0.0 ? max(own, min(whole, LEAST_SEEN)) : 0.0;
}

#define SEEN_COSINE(normal, eye, corner) \
    seen_cosine(normal, eye, placed_positions[corner.x], placed_positions[corner.y], placed_positions[corner.z])
