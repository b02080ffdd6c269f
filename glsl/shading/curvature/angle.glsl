// The angle of (x, y) from the x axis, from -pi to pi; not both are 0. The error is below 2e-7, and of small angles a
// relative 2e-7 (Cephes' atanf); drivers' own functions may be 4096 ULP off, or wrong if x is 0.
float angle_of(float y, float x) {
    float across = abs(y), along = abs(x), small = min(across, along), large = max(max(across, along), 1e-37);
    bool upper = small > 0.41421356 * large;
    float t = upper ? (small - large) / (small + large) : small / large, z = t * t;
    float fit = ((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1;
    float angle = (upper ? 0.785398163397448 : 0.0) + (t + t * z * fit);
    angle = across > along ? 1.57079632679490 - angle : angle;
    angle = x < 0.0 ? 3.14159265358979 - angle : angle;
    return y < 0.0 ? -angle : angle;
}
