#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "transport/blocks/lanes.glsl"

// For each error law the distances at which it takes evenly spaced values, in the logarithm: the inverse of a falling
// function by bisection. A law is the largest over the channels of
//   strength sum_j z_j p(s_j) (q2(sigma s_j) / (2 s_j^2))^n / level,  s_j^2 = u^2 + z_j^2,
// or, for any light of a contrast, of that times strength sum_j ...; for diffusion, of
//   (1/(z_b s) + (1 + k s)/s^2) e^(-k s) / (4 pi) (q2(k s) / (2 s^2))^n,  s^2 = u^2 + a share of a triangle's area.
layout(constant_id = 0) const uint CHANNELS = 7;
layout(constant_id = 1) const uint ORDER = 2;
layout(constant_id = 2) const uint ANY_LIGHT = 0;
layout(constant_id = 3) const uint LAYERS = 0;
READS(object_params)
READS(clusters)
READS(reference_level)
READS(counters)
WRITES(ranges)
#include "transport/blocks/channels.glsl"
#include "transport/blocks/acceptance_radii/laws.glsl"

float source(float sigma, float z, float u, float power) {
    float s2 = u * u + z * z, a = sigma * sqrt(s2);
    float q2 = (15.0 + a * (15.0 + a * (6.0 + a))) / (1.0 + a);
    return log2(z * (1.0 + a)) - 1.44269504 * a - 1.5 * log2(s2) + power * (log2(0.5 * q2) - log2(s2));
}

// What does not depend on the distance, loaded once.
vec3 sigma, z_real, z_virtual, boundary, strength, light;
float least;
void load() {
    sigma = object_params[0].sigma;
    if (LAYERS != 0) {
        boundary = object_params[0].boundary;
        least = clusters[0].area / (64.0 * float(object_params[0].faces));
        return;
    }
    z_real = object_params[0].z_real;
    z_virtual = object_params[0].z_virtual;
    EACH_CHANNEL({
        strength[c] = log2(max(object_params[0].strength[c] * (ANY_LIGHT != 0 ? 1.0 : object_params[0].tint[c]), 1e-37));
        light[c] = log2(ANY_LIGHT != 0 ? counters[0].contrast[c] : 1.0 / reference_level[0][c]);
    })
}

float layer_law(float u, float power) {
    float s2 = u * u + least, s = sqrt(s2);
    float largest = -1e30;
    for (uint c = 0; c < 3; ++c) {
        float a = sigma[c] * s;
        float both = 0.0795774715 * (1.0 / (boundary[c] * s) + (1.0 + a) / s2);
        float q2 = (15.0 + a * (15.0 + a * (6.0 + a))) / (1.0 + a);
        largest = max(largest, log2(both) - 1.44269504 * a + power * (log2(0.5 * q2) - log2(s2)));
    }
    return largest;
}

float law(float u, float power) {
    if (LAYERS != 0) return layer_law(u, power);
    float largest = -1e30;
    EACH_CHANNEL({
        float real = source(sigma[c], z_real[c], u, power);
        float virt = source(sigma[c], z_virtual[c], u, power);
        float both = max(real, virt) + log2(1.0 + exp2(min(real, virt) - max(real, virt)));
        largest = max(largest, both + strength[c] + light[c]);
    })
    return largest;
}

float power, wanted;
bool is_beyond(float root) {
    float squared = root * root;
    return law(squared * squared, power) <= wanted;
}

// One step of the bisection.
void halve(bool beyond, inout float low, inout float high) {
    float middle = 0.5 * (low + high);
    high = beyond ? middle : high;
    low = beyond ? low : middle;
}

// The fourth root of the distance: small distances matter as much as large ones.
const uint STEPS = 30;
const float LARGEST_ROOT = 1.41421356;
float root_alone() {
    float low = 0.0, high = LARGEST_ROOT;
    for (uint k = 0; k < STEPS; ++k) halve(is_beyond(0.5 * (low + high)), low, high);
    return high;
}

// The same steps, several at once: invocation 1 tries the middle, 2 and 3 those of the halves, 4 to 7 those of
// the quarters.
shared uint beyond[MOST_LANES];
float root_together() {
    uint self = gl_LocalInvocationIndex, at_once = findMSB(LANES);
    float low = 0.0, high = LARGEST_ROOT;
    for (uint done = 0; done < STEPS; done += at_once) {
        float own_low = low, own_high = high;
        for (int k = findMSB(self) - 1; k >= 0; --k) halve((self >> k & 1) == 0, own_low, own_high);
        beyond[self] = uint(is_beyond(0.5 * (own_low + own_high)));
        barrier();
        uint at = 1;
        for (uint k = done; k < min(done + at_once, STEPS); ++k) {
            bool first_half = beyond[at] != 0;
            halve(first_half, low, high);
            at = 2 * at + uint(!first_half);
        }
        barrier();
    }
    return high;
}

void main() {
    uint i = item();
    if (i >= ERROR_LAWS * RANGE_ENTRIES) return;
    uint which = i / RANGE_ENTRIES, entry = i % RANGE_ENTRIES;
    power = power_of(which);
    load();
    float top = law(0.0, power), depth = min(RANGE_DEPTH, top - law(FARTHEST, power));
    wanted = top - depth * float(entry) / float(RANGE_ENTRIES - 1);
    float root = LANES == 1 ? root_alone() : root_together();
    if (LANES > 1 && gl_LocalInvocationIndex > 0) return;
    float u = entry == 0 ? 0.0 : root * root * root * root;
    uint base = which * (RANGE_ENTRIES + 2);
    ranges[base + 2 + entry] = u;
    if (entry == 0) {
        ranges[base] = top;
        ranges[base + 1] = depth;
    }
}
