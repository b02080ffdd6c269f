// A cluster's layers on the surface, seen from afar: a charge w, a first moment U and a second moment Y of the kernel
//   g(s) = e^(-k s) / (4 pi s):  w g - U.grad g + Y : grad grad g - (Q, U) : grad grad grad g / 2,
// where Q is the second moment of the cluster's area about its middle. All vectors run over the channels. The includer
// reads the four buffers of layers, `second_moments` and `object_params`.
#include "transport/diffusion/kernel.glsl"

struct Layers { vec3 x, y, z, w; vec3 ux, uy, uz; vec3 xx, yy, zz, yz, zx, xy; };

Layers layers_of(uint node) {
    LayerPlace place = layer_places[node];
    LayerFirst first = layer_firsts[node];
    LayerSecond squares = layer_squares[node], products = layer_products[node];
    return Layers(place.x, place.y, place.z, place.charge, first.x, first.y, first.z, squares.x, squares.y, squares.z,
                  products.x, products.y, products.z);
}

// The value of a cluster's layers at a place; `x`, `y`, `z` run from their middle to it, in each channel.
vec3 layers_at(Layers m, SecondMoments area, Kernel kernel, vec3 x, vec3 y, vec3 z) {
    x *= kernel.by_s; y *= kernel.by_s; z *= kernel.by_s;
    vec3 along = m.ux * x + m.uy * y + m.uz * z;
    vec3 y_along = m.xx * x * x + m.yy * y * y + m.zz * z * z + 2.0 * (m.yz * y * z + m.zx * z * x + m.xy * x * y);
    vec3 q = area.diagonal, r = area.mixed;
    // Q d, and d.Q.d.
    vec3 qx = q.x * x + r.z * y + r.y * z, qy = r.z * x + q.y * y + r.x * z, qz = r.y * x + r.x * y + q.z * z;
    vec3 q_along = qx * x + qy * y + qz * z;
    vec3 third = kernel.c3 * q_along * along -
                 kernel.c2 * ((q.x + q.y + q.z) * along + 2.0 * (qx * m.ux + qy * m.uy + qz * m.uz));
    return kernel.g * (m.w + kernel.by_s * (kernel.c1 * along + kernel.by_s *
           (kernel.c2 * y_along - kernel.c1 * (m.xx + m.yy + m.zz) + 0.5 * kernel.by_s * third)));
}
