#version 460
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"
#include "invocation.glsl"

// Each node's four distances: beyond them its light is negligible, one link serves, one expansion serves, and 6 area
// points serve.
layout(constant_id = 0) const uint ORDER = 2;
layout(constant_id = 1) const uint ANY_LIGHT = 0;
layout(constant_id = 2) const uint LAYERS = 0;
READS(object_params)
READS(topology)
READS(bounds)
READS(clusters)
READS(moments)
READS(second_moments)
READS(ranges)
WRITES(emitters)
WRITES(expansion_distances)
#include "transport/blocks/acceptance_radii/laws.glsl"
#include "transport/blocks/chi.glsl"
#include "transport/diffusion/gain.glsl"

// The source that the laws bound: a node's light, or its area if lists have to serve any light.
struct Source { vec3 center; float strength; float trace; float radius; };

Source source_of(uint node) {
    if (ANY_LIGHT != 0) {
        Cluster cluster = clusters[node];
        vec3 corner = max(cluster.center - bounds[node].low, bounds[node].high - cluster.center);
        return Source(cluster.center, cluster.area, cluster.moment_trace, length(corner));
    }
    SecondMoments s = second_moments[node];
    return Source(moments[node].center, moments[node].weight, s.diagonal.x + s.diagonal.y + s.diagonal.z, s.radius);
}

// The distance beyond which a link of strength W tau^n, given as a logarithm, stays within `allowed`; `head` has the
// law's largest value, and how far it falls.
float range_of(uint which, vec2 head, float strength, float allowed) {
    uint base = which * (RANGE_ENTRIES + 2);
    float wanted = log2(allowed) - strength - log2(factor_of(which));
    float at = (head.x - wanted) / max(head.y, 1e-6) * float(RANGE_ENTRIES - 1);
    if (!(at > 0.0)) return 0.0;
    if (at >= float(RANGE_ENTRIES - 1)) return FARTHEST;
    uint entry = uint(at);
    return mix(ranges[base + 2 + entry], ranges[base + 3 + entry], at - float(entry));
}

// The distance below which a rule serves no triangle. Sources lie at least z = z_r off the surface.
float valid(float trace, float chi, float z) {
    float s = chi_distance(trace, chi);
    return sqrt(max(0.0, (s - z) * (s + z)));
}

// A law that holds at distance 0 holds everywhere.
float reach(float radius, float range) { return range > 0.0 ? radius + range : -1e9; }

void main() {
    uint node = invocation();
    // Values that all invocations share are read before any of them returns: after that some drivers read them once for
    // each.
    float z = min(object_params[0].z_real.x, min(object_params[0].z_real.y, object_params[0].z_real.z)), error = object_params[0].link_error;
    // Layers lie on the surface.
    z = LAYERS != 0 ? 0.0 : z;
    if (LAYERS != 0) error *= layer_gain(clusters[0].area);
    // The mean square radius of a flat disc of a block's mean area; each further class has four times more.
    float disc = log2(max(clusters[0].area / (6.2831853 * float(object_params[0].usual_blocks)), 1e-30));
    vec2 heads[ERROR_LAWS];
    for (uint k = 0; k < ERROR_LAWS; ++k) {
        heads[k] = vec2(ranges[k * (RANGE_ENTRIES + 2)], ranges[k * (RANGE_ENTRIES + 2) + 1]);
    }
    if (node >= object_params[0].nodes) return;
    Source source = source_of(node);
    uint skip = topology[node].skip;
    uint right = skip == node + 1 ? 0 : topology[node + 1].skip;
    Emitter emitter = Emitter(vec4(source.center, -1e9), 0, 0, skip, right);
    vec4 expand = vec4(0);
    if (source.strength > 0.0) {
        float weight = log2(source.strength), tau = log2(max(source.trace, 1e-30));
        bool leaf = skip == node + 1;
        uint rule = leaf ? LAW_SAMPLE : LAW_MOMENTS;
        vec2 head = leaf ? heads[LAW_SAMPLE] : heads[LAW_MOMENTS];
        float trace = source.trace;
        float accept = range_of(rule, head, weight + power_of(rule) * tau, error);
        if (leaf) accept = max(accept, valid(trace, SAMPLE_CHI, z));
        // The laws hold from a cluster's nearest point, and from a triangle's centroid.
        float radius = leaf ? 0.0 : source.radius;
        emitter.place.w = reach(source.radius, range_of(LAW_MAGNITUDE, heads[LAW_MAGNITUDE],
                                                        weight, DROPPED_SHARE * error));
        emitter.accept = reach(radius, accept);
        for (uint k = 0; k < 4; ++k) {
            float spread = power_of(LAW_EXPANSION) * (disc + 2.0 * float(k));
            float bent = range_of(LAW_EXPANSION, heads[LAW_EXPANSION], weight + spread, EXPANDED_SHARE * error);
            expand[k] = reach(radius, max(accept, bent));
        }
        if (leaf) {
            float points = range_of(LAW_AREA, heads[LAW_AREA], weight + power_of(LAW_AREA) * tau, error);
            emitter.area = reach(radius, max(valid(trace, AREA_CHI, z), points));
        }
    }
    emitters[node] = emitter;
    expansion_distances[node] = expand;
}
