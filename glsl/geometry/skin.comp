#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Applies morph targets to an object's vertices, then the joints that they follow. Additions and multiplications only:
// the same bits on every device.
READS(object_params)
READS(skin_vertices)
READS(skin_joints)
READS(skin_targets)
READS(skin_weights)
READS(skin_matrices)
WRITES(skinned)

float row(vec4 m, vec3 p) {
    precise float sum = m.x * p.x + m.y * p.y + m.z * p.z + m.w;
    return sum;
}

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    SkinVertex own = skin_vertices[vertex];
    uint targets = object_params[0].skin_targets, joints = object_params[0].skin_joints;
    vec3 p = own.base;
    uint first = object_params[0].first_target + vertex * targets, weights = object_params[0].first_weight + own.row;
    for (uint k = 0; k < targets; ++k) {
        precise vec3 next = p + skin_weights[weights + k] * skin_targets[first + k];
        p = next;
    }
    vec3 sum = vec3(0.0);
    first = object_params[0].first_joint + vertex * joints;
    for (uint k = 0; k < joints; ++k) {
        SkinJoint joint = skin_joints[first + k];
        SkinMatrix m = skin_matrices[object_params[0].first_matrix + joint.matrix];
        vec3 q = vec3(row(m.x, p), row(m.y, p), row(m.z, p));
        precise vec3 next = sum + joint.weight * q;
        sum = next;
    }
    skinned[vertex] = sum;
}
