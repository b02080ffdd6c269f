#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Curvature of a vertex from the triangles around it. The angle deficit is a small difference of large numbers. It is
// summed triangle by triangle instead, as the increase of each angle by projection along the normal. Projected angles
// add up to full turns; the plain sum gives their number, and serves alone if an edge runs nearly along the normal, as
// at sharp rims, where the deficit is not small.
READS(object_params)
READS(positions)
READS(triangles)
READS(corner_starts)
READS(corners)
READS(normals)
WRITES(curvature)
#include "shading/curvature/ring.glsl"
#include "shading/curvature/angle.glsl"

const float TURN = 6.28318530717959;

// A hash of a vertex: equal sums mean that two sets have the same vertices.
uint mark(uint vertex) {
    uint h = (vertex ^ (vertex >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    uint self = object_params[0].first_vertex + vertex, after = 0, before = 0;
    vec3 normal = normals[vertex], pull = vec3(0), a = positions[self];
    float area = 0.0, angle = 0.0, deficit = 0.0, least = 1.0;
    for (uint i = corner_starts[vertex]; i < corner_starts[vertex + 1]; ++i) {
        uvec3 corner = turned(triangles[corners[i]], self);
        after += mark(corner.y);
        before += mark(corner.z);
        vec3 b = positions[corner.y], c = positions[corner.z], u = b - a, w = c - a, e = c - b;
        // Whether the triangle has an area is a decision; a fused operation would turn rounding into an area.
        precise vec3 n = u.yzx * w.zxy - u.zxy * w.yzx;
        precise float square = n.x * n.x + n.y * n.y + n.z * n.z;
        bool whole = square > FLAT_TRIANGLE;
        float twice = sqrt(square);
        float over = whole ? 1.0 / twice : 0.0;
        float da = dot(u, w), db = -dot(u, e), dc = dot(w, e);
        float cb = clamp(db * over, -MOST_COTANGENT, MOST_COTANGENT);
        float cc = clamp(dc * over, -MOST_COTANGENT, MOST_COTANGENT);
        pull += whole ? cc * u + cb * w : vec3(0);
        float part = (dot(u, u) * cc + dot(w, w) * cb) / 8.0;
        part = db < 0.0 || dc < 0.0 ? twice / 8.0 : part;
        area += whole ? (da < 0.0 ? twice / 4.0 : part) : 0.0;
        // With N the vertex normal, ab = (u.N) (w.N) and cos = N.n / |n|:
        // tan(projected - own) = |n| (ab - da (1 - cos)) / (da (da - ab) + |n|^2 cos).
        vec3 tilt = normal - n * over;
        float lost = 0.5 * dot(tilt, tilt), rise = dot(u, normal) * dot(w, normal);
        float across = twice * (rise - da * lost), along = da * (da - rise) + twice * twice * (1.0 - lost);
        float up = dot(u, normal), off = dot(w, normal), uu = dot(u, u), ww = dot(w, w);
        least = min(least, min(1.0 - up * up / max(uu, 1e-37), 1.0 - off * off / max(ww, 1e-37)));
        deficit += whole ? angle_of(across, along) : 0.0;
        angle += whole ? angle_of(twice, da) : 0.0;
    }
    Curvature found = Curvature(0.0, 0.0, 0.0, 0.0);
    // The normal is of unit length, or 0 if sheets lie back to back: there is no curvature then.
    bool stands = dot(normal, normal) > 0.5;
    if (stands && after == before && corner_starts[vertex + 1] > corner_starts[vertex] && area > LEAST_MIXED_AREA) {
        float plain = TURN - angle;
        deficit = least < 0.25 ? plain : deficit - TURN * round((deficit - plain) / TURN);
        // `pull` sums edges that point away from the vertex, those of the formula point to it: hence the minus sign.
        float mean = clamp(-dot(pull, normal) / (4.0 * area), -MOST_CURVATURE, MOST_CURVATURE);
        float gaussian = clamp(deficit / area, -MOST_CURVATURE * MOST_CURVATURE, MOST_CURVATURE * MOST_CURVATURE);
        float rms = sqrt(mean * mean + max(mean * mean - gaussian, 0.0));
        found = Curvature(object_params[0].kappa == KAPPA_RMS ? rms : abs(mean), mean, gaussian, area);
    }
    curvature[vertex] = found;
}
