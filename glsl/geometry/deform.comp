#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Twists, bends, raises and morphs an object's vertices, starting from their positions at rest. Additions,
// multiplications and comparisons only, in sine and cosine too: the same bits on every device.
READS(object_params)
READS(rest)
READS(rest_normals)
READS(deforms)
READS(morphs)
READS(skinned)
UPDATES(positions)

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

#include "geometry/turn.glsl"

// The gradient at the corner `step` of a lattice cell, times the vector from that corner.
float corner(uvec3 cell, vec3 f, uvec3 step) {
    uvec3 at = cell + step;
    uint h = (at.x * 0x8da6b343u) ^ (at.y * 0xd8163841u) ^ (at.z * 0xcb1ab31fu);
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    precise vec3 d = f - vec3(step);
    float u = (h & 8u) == 0u ? d.x : d.y;
    float v = (h & 12u) == 0u ? d.y : (h & 13u) == 12u ? d.x : d.z;
    precise float sum = ((h & 1u) == 0u ? u : -u) + ((h & 2u) == 0u ? v : -v);
    return sum;
}

float mix3(float a, float b, float t) {
    precise float sum = a + t * (b - a);
    return sum;
}

// Gradient noise, -1 to 1.
float noise(vec3 p) {
    vec3 low = floor(p);
    uvec3 cell = uvec3(ivec3(low));
    precise vec3 f = p - low;
    precise vec3 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    float a = mix3(corner(cell, f, uvec3(0, 0, 0)), corner(cell, f, uvec3(1, 0, 0)), fade.x);
    float b = mix3(corner(cell, f, uvec3(0, 1, 0)), corner(cell, f, uvec3(1, 1, 0)), fade.x);
    float c = mix3(corner(cell, f, uvec3(0, 0, 1)), corner(cell, f, uvec3(1, 0, 1)), fade.x);
    float d = mix3(corner(cell, f, uvec3(0, 1, 1)), corner(cell, f, uvec3(1, 1, 1)), fade.x);
    return mix3(mix3(a, b, fade.y), mix3(c, d, fade.y), fade.z);
}

vec3 twist(Deform d, vec3 from) {
    float height = dot3(from, d.axis);
    precise float inside = clamp(height - d.low, 0.0, d.extent);
    precise float turns = d.rate * inside;
    vec2 sc = turn(turns);
    vec3 a = d.axis;
    precise vec3 q = from - height * a;
    precise vec3 side = vec3(a.y * q.z - a.z * q.y, a.z * q.x - a.x * q.z, a.x * q.y - a.y * q.x);
    precise vec3 place = d.origin + (height * a + (sc.y * q + sc.x * side));
    return place;
}

vec3 bend(Deform d, vec3 p, vec3 from) {
    float height = dot3(from, d.axis), lean = dot3(from, d.toward);
    precise float above = height - d.low;
    precise float inside = clamp(above, 0.0, d.extent);
    precise float beyond = above - inside;
    precise float turns = d.rate * inside;
    vec2 sc = turn(turns);
    // Up the arc, and sideways; with little curvature the radius is long and would cancel, so a series serves.
    precise float phi = 6.2831855 * turns;
    precise float z = phi * phi;
    bool straight = z < 0.0625;
    precise float low_rise = inside * (1.0 - z * (0.16666667 - z * 0.008333334));
    precise float high_rise = d.amount * sc.x;
    precise float part = 0.5 - z * (0.041666668 - z * 0.0013888889);
    precise float low_drift = inside * (phi * part);
    precise float high_drift = d.amount * (1.0 - sc.y);
    float rise = straight ? low_rise : high_rise, drift = straight ? low_drift : high_drift;
    precise float up = d.low + rise - lean * sc.x + beyond * sc.y - height;
    precise float out_ = drift + lean * sc.y + beyond * sc.x - lean;
    precise vec3 place = p + (up * d.axis + out_ * d.toward);
    return place;
}

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    vec3 p = rest[vertex], normal = rest_normals[vertex];
    for (uint i = 0; i < object_params[0].deforms; ++i) {
        Deform d = deforms[object_params[0].first_deform + i];
        precise vec3 from = p - d.origin;
        if (d.kind == DEFORM_TWIST) {
            p = twist(d, from);
        } else if (d.kind == DEFORM_BEND) {
            p = bend(d, p, from);
        } else if (d.kind <= DEFORM_BUMP_NORMAL) {
            precise float share = 1.0 - dot3(from, from) * d.rate;
            precise float height = share > 0.0 ? d.amount * (share * share) : 0.0;
            vec3 along = d.kind == DEFORM_BUMP_AXIS ? d.axis : normal;
            precise vec3 place = p + height * along;
            p = place;
        } else if (d.kind == DEFORM_MORPH) {
            precise vec3 place = p + d.amount * morphs[d.first + vertex];
            p = place;
        } else if (d.kind == DEFORM_SKIN) {
            p = skinned[vertex];
        } else {
            precise vec3 at = from * d.rate;
            precise float height = d.amount * noise(at);
            precise vec3 place = p + height * normal;
            p = place;
        }
    }
    positions[object_params[0].first_vertex + vertex] = p;
}
