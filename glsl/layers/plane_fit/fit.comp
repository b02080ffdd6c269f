#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// The plane of least squares through the vertices within `fit_radius` of a vertex: a walk over the tree takes clusters
// that lie inside as one, and the vertices of triangles on the border one by one.
READS(object_params)
READS(positions)
READS(normals)
READS(triangles)
READS(corner_starts)
READS(corners)
READS(topology)
READS(bounds)
READS(vertex_moments)
WRITES(planes)
UPDATES(cut_short)
#include "layers/vertex_moments.glsl"

float square(vec3 d) {
    precise float sum = d.x * d.x + d.y * d.y + d.z * d.z;
    return sum;
}

// A rotation of the axes p and q after which their product of inertia is 0: cosine and sine (Jacobi).
vec2 rotation(float pp, float qq, float pq) {
    float half_difference = 0.5 * (qq - pp);
    float length2 = half_difference * half_difference + pq * pq;
    if (length2 <= 0.0) return vec2(1, 0);
    float t = pq / (abs(half_difference) + sqrt(length2));
    t = half_difference < 0.0 ? -t : t;
    float c = 1.0 / sqrt(1.0 + t * t);
    return vec2(c, t * c);
}

void main() {
    uint vertex = invocation();
    if (vertex >= object_params[0].vertices) return;
    vec3 here = positions[object_params[0].first_vertex + vertex], normal = normals[vertex];
    precise float r2 = object_params[0].fit_radius * object_params[0].fit_radius;
    VertexMoments sum = VertexMoments(0.0, vec3(0), vec3(0), vec3(0));
    uint node = 0;
    while (node < object_params[0].nodes) {
        Bounds box = bounds[node];
        precise vec3 low = box.low - here, high = box.high - here;
        float nearest = square(max(max(low, -high), vec3(0))), farthest = square(max(abs(low), abs(high)));
        bool meets = nearest <= r2, inside = farthest <= r2, leaf = topology[node].face != NONE;
        VertexMoments own = vertex_moments[node];
        own.center -= here;
        if (!inside) own.count = 0.0;
        own.diagonal *= inside ? 1.0 : 0.0;
        own.mixed *= inside ? 1.0 : 0.0;
        if (meets && leaf && !inside) {
            uint face = topology[node].face;
            for (uint k = 0; k < 3; ++k) {
                uint other = triangles[face][k];
                precise vec3 d = positions[other] - here;
                bool counts = corners[corner_starts[other - object_params[0].first_vertex]] == face && square(d) <= r2;
                own = joined(own, VertexMoments(counts ? 1.0 : 0.0, d, vec3(0), vec3(0)));
            }
        }
        if (meets) sum = joined(sum, own);
        node = meets && !inside && !leaf ? node + 1 : topology[node].skip;
    }

    if (node < object_params[0].nodes) cut_short[0] = 1;

    // The axes of the vertices' second moments, by rotating pair after pair of axes.
    float trace = sum.diagonal.x + sum.diagonal.y + sum.diagonal.z;
    vec3 d = vec3(0, 0, 1), m = vec3(0), x = vec3(1, 0, 0), y = vec3(0, 1, 0), z = vec3(0, 0, 1);
    if (trace > 0.0) {
        d = sum.diagonal / trace;
        m = sum.mixed / trace;
    }
    for (uint sweep = 0; sweep < 6; ++sweep) {
        // x with y, y with z, z with x; after each the names go round.
        for (uint pair = 0; pair < 3; ++pair) {
            vec2 r = rotation(d.x, d.y, m.z);
            vec3 old_x = x, old_d = d, old_m = m;
            x = r.x * old_x - r.y * y;
            y = r.y * old_x + r.x * y;
            d.x = r.x * r.x * old_d.x + r.y * r.y * old_d.y - 2.0 * r.x * r.y * old_m.z;
            d.y = r.y * r.y * old_d.x + r.x * r.x * old_d.y + 2.0 * r.x * r.y * old_m.z;
            m = vec3(r.y * old_m.y + r.x * old_m.x, r.x * old_m.y - r.y * old_m.x, 0.0);
            vec3 first = x;
            x = y;
            y = z;
            z = first;
            d = d.yzx;
            m = m.yzx;
        }
    }

    // The plane's normal is the axis of least moment, as far as the vertices determine it.
    vec3 axis = d.x < d.y ? (d.x < d.z ? x : z) : (d.y < d.z ? y : z);
    float least = max(min(d.x, min(d.y, d.z)), 0.0), most = max(d.x, max(d.y, d.z));
    float middle = max(d.x + d.y + d.z - least - most, 1e-30);
    float along = dot(axis, normal);
    axis = along < 0.0 ? -axis : axis;
    float trust = sum.count < 3.0 || trace <= 0.0 ? 0.0
        : (1.0 - smoothstep(0.25, 0.5, least / middle)) * smoothstep(0.01, 0.05, middle / most)
          * smoothstep(0.5, 0.8, abs(along));
    vec3 mixed = mix(normal, axis, trust);
    vec3 fitted = mixed / sqrt(max(dot(mixed, mixed), 1e-30));
    planes[vertex] = vec4(fitted, trust * dot(sum.center, fitted));
}
