#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// A cluster's layers from its two children's, shifted to its middle. The middle is that of the area; for the source
// term, which is nowhere negative, it is that of the charge in each channel.
layout(constant_id = 0) const uint SOURCE = 0;
READS(object_params)
READS(topology)
READS(moments)
READS(second_moments)
SHARES(layer_places)
SHARES(layer_firsts)
SHARES(layer_squares)
SHARES(layer_products)
#include "climb.glsl"
#include "transport/diffusion/layers.glsl"

// Adds a child whose middle is at x, y, z from the cluster's.
void add(inout Layers sum, Layers one, vec3 x, vec3 y, vec3 z) {
    vec3 half_w = 0.5 * one.w;
    sum.w += one.w;
    sum.xx += one.xx + x * (one.ux + half_w * x);
    sum.yy += one.yy + y * (one.uy + half_w * y);
    sum.zz += one.zz + z * (one.uz + half_w * z);
    sum.yz += one.yz + 0.5 * (y * one.uz + z * one.uy) + half_w * y * z;
    sum.zx += one.zx + 0.5 * (z * one.ux + x * one.uz) + half_w * z * x;
    sum.xy += one.xy + 0.5 * (x * one.uy + y * one.ux) + half_w * x * y;
    sum.ux += one.ux + one.w * x;
    sum.uy += one.uy + one.w * y;
    sum.uz += one.uz + one.w * z;
}

void of_cluster(uint node, uint right) {
    uint left = node + 1;
    Layers l = layers_of(left), r = layers_of(right);
    vec3 center = moments[node].center;
    vec3 x = vec3(center.x), y = vec3(center.y), z = vec3(center.z);
    if (SOURCE != 0) {
        vec3 w = l.w + r.w;
        vec3 share = mix(vec3(0.5), r.w / max(w, vec3(1e-37)), greaterThan(w, vec3(0)));
        x = mix(l.x, r.x, share);
        y = mix(l.y, r.y, share);
        z = mix(l.z, r.z, share);
    }
    Layers sum = Layers(x, y, z, vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0));
    add(sum, l, l.x - x, l.y - y, l.z - z);
    add(sum, r, r.x - x, r.y - y, r.z - z);
    layer_places[node] = LayerPlace(x, y, z, sum.w);
    // About the middle of the charge there is no first moment.
    bool none = SOURCE != 0;
    layer_firsts[node] = none ? LayerFirst(vec3(0), vec3(0), vec3(0)) : LayerFirst(sum.ux, sum.uy, sum.uz);
    layer_squares[node] = LayerSecond(sum.xx, sum.yy, sum.zz);
    layer_products[node] = LayerSecond(sum.yz, sum.zx, sum.xy);
}
