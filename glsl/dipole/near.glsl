// Squared distance, for decisions on which triangles are too near for one sample: exact on every device.
float distance2(vec3 a, vec3 b) {
    precise vec3 d = a - b;
    precise float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    return d2;
}
