// The kernel g(s) = e^(-k s) / (4 pi s) at a distance, and factors of its derivatives: c1 = 1 + a, c2 = 3 + 3a + a^2,
// c3 = 15 + 15a + 6a^2 + a^3 for a = k s; and 1 / s. The includer reads `object_params`.
struct Kernel { vec3 g, c1, c2, c3, by_s; };

Kernel kernel_at(vec3 s2) {
    vec3 s = sqrt(max(s2, vec3(1e-30))), a = object_params[0].sigma * s;
    Kernel kernel;
    kernel.by_s = 1.0 / s;
    kernel.g = 0.0795774715 * exp(-a) * kernel.by_s;
    kernel.c1 = 1.0 + a;
    kernel.c2 = 3.0 + a * (3.0 + a);
    kernel.c3 = 15.0 + a * (15.0 + a * (6.0 + a));
    return kernel;
}
