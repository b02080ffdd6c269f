// sigma = sigma_0 kappa at a point, and the CDRF's factors on the environment. MAPPED is not 0 if an object has a map
// of d; sigma_0 is multiplied by d^2 (equation 6).
layout(constant_id = 3) const uint MAPPED = 0;
READS(corner_uvs)
READS(texels)
#include "lighting/texture.glsl"

vec3 local_sigma(vec3 sigma, uint object, uint face, vec3 weight) {
    if (MAPPED != 0) {
        uvec2 size = max(object_params[object].sigma_0_size, uvec2(1));
        vec2 place = texture_place(corner_uvs[face], weight.yz);
        vec3 d = texture_at(object_params[object].sigma_0_first, size, object_params[object].texture_wrap, place);
        sigma *= object_params[object].sigma_0_size.x > 0 ? d * d : vec3(1);
    }
    return sigma;
}

// 2 pi times the integrals of f(mu) P_l(mu) over mu from -1 to 1, for l of 0, 1 and 2, by the cosine series. The last
// term counts by half: where sigma is 0 the signs alternate.
mat3 respond_sky(vec3 sigma) {
    vec3 s = min(sigma, vec3(8.0)), e = exp(-0.5 * s * s), q = e * e;
    q *= q;
    vec3 q2 = q * q, power = q, factor = q2 * q, zero = vec3(4.0), two = vec3(0);
    float sign = 4.0, last = 2.0, own = -2.0 / 3.0;
    for (int n = 1; n <= 16; ++n) {
        float square = float(4 * n * n), next = -2.0 / (square + float(8 * n) + 3.0);
        vec3 term = (n < 16 ? sign : 0.5 * sign) / (square - 1.0) * power;
        zero += term * own;
        two += term * 0.25 * (own + 1.5 * (next + last));
        power *= factor;
        factor *= q2;
        last = own;
        own = next;
        sign = -sign;
    }
    return mat3(zero, 2.09439510239320 * e, two);
}
