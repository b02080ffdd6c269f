#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

// The coarse solution at a few receivers: one half drawn evenly among the triangles, one half by the light.
layout(constant_id = 0) const uint CHANNELS = 7;
READS(object_params)
READS(topology)
READS(leaves)
READS(clusters)
READS(moments)
READS(second_moments)
WRITES(samples)
#include "dipole/near.glsl"
#include "dipole/derivatives.glsl"
#include "transport/blocks/channels.glsl"
const uint WORDS = 1024;
#include "transport/blocks/share.glsl"

// All words must fit.
bool take(uint total) { return false; }

const uint HALF = COARSE_SAMPLES / 2;
const uint COARSE_RUN = 16; // clusters that are summed by themselves

// The leaf of the triangle at sample k's share of the light: decisions, so exact. What a level needs is loaded at once.
uint by_light(uint k) {
    precise float target = moments[0].weight * ((float(k) + 0.5) * (1.0 / float(HALF)));
    uint node = 0, last = object_params[0].nodes - 1, right = topology[min(1, last)].skip;
    bool leaf = topology[0].face != NONE;
    while (!leaf) {
        uint left = node + 1;
        float before = moments[left].weight, after = moments[right].weight;
        uint right_of_left = topology[left + 1].skip, right_of_right = topology[min(right + 1, last)].skip;
        bool left_ends = topology[left].face != NONE, right_ends = topology[right].face != NONE;
        bool goes_left = target < before || !(after > 0.0);
        precise float rest = target - before;
        target = goes_left ? target : rest;
        node = goes_left ? left : right;
        leaf = goes_left ? left_ends : right_ends;
        right = goes_left ? right_of_left : right_of_right;
    }
    return node;
}

vec3 x; // the sample's position
vec3 plane; // radiosity under the whole plane of unit irradiance
Dipole dipoles[3];

// Whether a node is far enough to be taken as a whole.
bool is_far(Moment m, float coarse) {
    precise float reach2 = coarse * coarse;
    return distance2(x, m.center) >= reach2;
}

// The light that a far node sends to the sample, or a triangle that is not far.
vec3 sent(uint node, Moment m, SecondMoments s, bool far) {
    vec3 d = x - m.center, sum = vec3(0);
    float d2 = dot(d, d), tau = s.diagonal.x + s.diagonal.y + s.diagonal.z;
    float along = dot(s.diagonal, d * d) + 2.0 * dot(s.mixed, d.yzx * d.zxy);
    float area = far ? 1.0 : max(clusters[node].area, 1e-30);
    EACH_CHANNEL({
        vec3 p = profile_derivatives(dipoles[c], d2);
        float value = m.weight * (far ? p.x + 0.5 * (p.y * tau + p.z * along) : p.x);
        // No triangle gives more than the whole plane would.
        sum[c] = far ? value : min(value, plane[c] * m.weight / area);
    })
    return sum;
}

uint visit(uint node, out uint word) {
    // Everything is loaded at once, even data that only some nodes need.
    uint skip = topology[node].skip, right = topology[min(node + 1, object_params[0].nodes - 1)].skip;
    Moment m = moments[node];
    bool far = is_far(m, second_moments[node].coarse), opens = m.weight > 0.0 && !far && skip != node + 1;
    word = m.weight > 0.0 && !opens ? node << 1 | uint(far) : NONE;
    return opens ? right : 0;
}

// The sum over the tree: each run of COARSE_RUN clusters is summed by itself, then these sums are, so that runs may be
// summed at once.
vec3 sum_alone() {
    vec3 sum = vec3(0), run = vec3(0);
    uint node = 0, end = object_params[0].nodes, count = 0;
    while (node < end) {
        Moment m = moments[node];
        SecondMoments s = second_moments[node];
        uint skip = topology[node].skip;
        bool far = is_far(m, s.coarse), lit = m.weight > 0.0, opens = lit && !far && skip != node + 1;
        if (lit && !opens) {
            run += sent(node, m, s, far);
            ++count;
            bool full = count == COARSE_RUN;
            sum += full ? run : vec3(0);
            run = full ? vec3(0) : run;
            count = full ? 0 : count;
        }
        node = opens ? node + 1 : skip;
    }
    return sum + run;
}

const uint AT_ONCE = 8 * COARSE_RUN; // what clusters send is kept, and summed by run
shared vec3 values[AT_ONCE];
shared vec3 run_sums[WORDS / COARSE_RUN];

// The same sum, for the first invocation of the group.
vec3 sum_together() {
    uint self = gl_LocalInvocationIndex;
    if (!walk_together()) return self == 0 ? sum_alone() : vec3(0);
    uint total = found_count, runs = (total + COARSE_RUN - 1) / COARSE_RUN;
    sort_found(total);
    for (uint first = 0; first < total; first += AT_ONCE) {
        uint count = min(total - first, AT_ONCE);
        for (uint k = self; k < count; k += LANES) {
            uint word = found(first + k), node = word >> 1;
            values[k] = sent(node, moments[node], second_moments[node], (word & 1) != 0);
        }
        barrier();
        for (uint run = self; run * COARSE_RUN < count; run += LANES) {
            vec3 sum = vec3(0);
            uint last = min((run + 1) * COARSE_RUN, count);
            for (uint k = run * COARSE_RUN; k < last; ++k) sum += values[k];
            run_sums[first / COARSE_RUN + run] = sum;
        }
        barrier();
    }
    vec3 sum = vec3(0);
    if (self == 0) for (uint run = 0; run < runs; ++run) sum += run_sums[run];
    return sum;
}

void main() {
    uint k = item();
    if (k >= COARSE_SAMPLES) return;
    uint even = min(uint((float(k) + 0.5) * (1.0 / float(HALF)) * float(object_params[0].faces)), object_params[0].faces - 1);
    uint leaf = k < HALF ? leaves[even] : by_light(k - HALF);
    x = clusters[leaf].center;
    float whole = moments[0].weight;
    float light = whole > 0.0 ? moments[leaf].weight / whole : 0.0;

    plane = 6.2831853 * object_params[0].strength * object_params[0].tint *
        (exp(-object_params[0].sigma * object_params[0].z_real) + exp(-object_params[0].sigma * object_params[0].z_virtual));
    dipoles = Dipole[3](dipole_of(0), dipole_of(1), dipole_of(2));
    vec3 sum = LANES == 1 ? sum_alone() : sum_together();
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    float chance = 0.5 / float(object_params[0].faces) + 0.5 * light;
    float area = clusters[leaf].area, mean = clusters[0].area / float(object_params[0].faces);
    // One factor after the other, so that nothing leaves the range of f32.
    float enters = area > 0.0 && whole > 0.0 ? light * (clusters[0].area / area) : 0.0;
    float share = mean > 0.0 ? area / mean : 0.0;
    samples[k] = Sample(topology[leaf].face, chance, max(sum, vec3(0)),
                        enters * enters * (share / (chance * float(object_params[0].faces))));
}
