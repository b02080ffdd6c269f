#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// A triangle's layers: those of the vector that the operator is applied to, or of the source term, which lies deeper.
layout(constant_id = 0) const uint SOURCE = 0;
layout(constant_id = 1) const uint SOLUTION = 0;
layout(push_constant, scalar) uniform push_block { uint step; };
READS(object_params)
READS(leaves)
READS(clusters)
READS(moments)
READS(second_moments)
READS(deposits)
READS(krylov)
READS(solution)
WRITES(layer_places)
WRITES(layer_firsts)
WRITES(layer_squares)
WRITES(layer_products)

void main() {
    uint face = invocation();
    if (face >= object_params[0].faces) return;
    uint node = leaves[face];
    Cluster cluster = clusters[node];
    vec3 center = moments[node].center, by_z = 1.0 / object_params[0].boundary;
    vec3 x = vec3(center.x), y = vec3(center.y), z = vec3(center.z), b;
    LayerFirst first = LayerFirst(vec3(0), vec3(0), vec3(0));
    if (SOURCE != 0) {
        Deposit deposit = deposits[face];
        x += vec3(deposit.red.x, deposit.green.x, deposit.blue.x);
        y += vec3(deposit.red.y, deposit.green.y, deposit.blue.y);
        z += vec3(deposit.red.z, deposit.green.z, deposit.blue.z);
        b = cluster.area * deposit.light;
    } else {
        vec3 value = SOLUTION != 0 ? solution[face] : krylov[step * object_params[0].faces + face];
        b = cluster.area * value;
        first = LayerFirst(value * cluster.normal.x, value * cluster.normal.y, value * cluster.normal.z);
    }
    vec3 charge = b * by_z;
    SecondMoments area = second_moments[node];
    layer_places[node] = LayerPlace(x, y, z, charge);
    layer_firsts[node] = first;
    layer_squares[node] = LayerSecond(0.5 * charge * area.diagonal.x, 0.5 * charge * area.diagonal.y,
                                      0.5 * charge * area.diagonal.z);
    layer_products[node] = LayerSecond(0.5 * charge * area.mixed.x, 0.5 * charge * area.mixed.y,
                                       0.5 * charge * area.mixed.z);
}
