#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "layout.glsl"
#include "shuffle.glsl"

// The first triangle that each pixel's ray hits. The rays of a team are those of a tile, two pixels high.
const uint TEAM_GROUP = GROUP_SIZE;
layout(local_size_x = TEAM_GROUP) in;
layout(constant_id = 0) const uint TEAM = 8; // rays that go together; 1: each goes alone
READS(object_params)
READS(camera)
READS(placed_positions)
READS(triangles)
READS(placed_bounds)
READS(wide_boxes)
WRITES(hits)
#include "geometry/trace.glsl"
#include "geometry/shaft.glsl"
#include "view/ray.glsl"

// Rays differ from the one along `shaft_axis` by at most `shaft_spread` per unit of distance. The dot product of
// `shaft_forward` and a place relative to the eye is at least the distance there.
vec3 shaft_spread, shaft_forward;
Sight shaft_axis;
Nearest shaft_end;

bool in_shaft(vec3 low, vec3 high) {
    vec3 middle = 0.5 * (low + high) - camera[0].origin, size = 0.5 * (high - low);
    float way = max(dot(middle, shaft_forward) + dot(size, abs(shaft_forward)), 0.0);
    vec3 spread = way * shaft_spread;
    return meets(low - spread, high + spread, camera[0].origin, shaft_axis, shaft_end);
}

// The nearest hit; its face is UNFINISHED where the ray has to go alone.
Nearest together(vec3 direction) {
    Place self = place_in_team();
    vec3 origin = camera[0].origin;
    vec3 low = least(direction), high = -least(-direction);
    shaft_axis = sight(0.5 * (low + high));
    shaft_spread = 0.5 * (high - low) + 1e-5 * max(abs(low), abs(high));
    float slowest = least(vec3(dot(direction, camera[0].forward))).x;
    shaft_forward = camera[0].forward * (1.0001 / slowest);
    shaft_end = Nearest(NONE, vec3(0), 0.0, 1.0);

    Sight ray = sight(direction);
    Nearest nearest = shaft_end;
    float along = dot(ray.along, shaft_axis.along) / ray.square;
    bool left = false;
    Waiting way = Waiting(0, object_params[0].wide_tops, 0);
    while (goes_on(way)) {
        uint count = list_triangles(self, way), at = 0;
        for (; at < count; at += TEAM) {
            uint face = pool[self.list + min(at + self.mine, count - 1)];
            uvec3 corner = triangles[face];
            vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
            for (uint k = 0; k < TEAM; ++k) {
                uint from = self.base + k;
                nearest = nearer(nearest, ray, origin, shuffled(face, from), shuffled(a, from), shuffled(b, from),
                                 shuffled(c, from));
            }
        }
        left = left || at < count;
        // Boxes behind the hits of all rays are left out.
        float end = nearest.face == NONE ? NO_BOX : nearest.numerator / nearest.denominator * along;
        shaft_end = Nearest(0, vec3(0), -1.0001 * least(vec3(-end)).x, 1.0);
    }
    if (left || waits(way)) nearest.face = UNFINISHED;
    return along_ray(nearest, ray);
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint width = camera[0].width, height = camera[0].height;
    uint across = max(TEAM / 2, 1), tiles = (width + across - 1) / across;
    uint tile = group * (TEAM_GROUP / TEAM) + lane() / TEAM, mine = lane() % TEAM;
    uvec2 place = uvec2(tile % tiles * across + mine % across, tile / tiles * min(TEAM, 2) + mine / across);

    // All invocations of a team stay: past the edge they follow the last pixel's ray.
    bool there = place.x < width && place.y < height;
    uint pixel = min(place.y, height - 1) * width + min(place.x, width - 1);
    vec3 direction = ray(pixel);
    precise float z = float(width) * float(height);
    Nearest nearest = Nearest(UNFINISHED, vec3(0), 0.0, 1.0);
    if (in_teams()) nearest = together(direction);
    if (!there) return;
    if (nearest.face == UNFINISHED) nearest = trace(camera[0].origin, direction);

    float sum = nearest.weights.x + nearest.weights.y + nearest.weights.z;
    Hit hit = Hit(nearest.face, 0.0, 0.0, 0.0);
    if (nearest.face < UNFINISHED) {
        float depth = nearest.numerator / nearest.denominator * z;
        hit = Hit(nearest.face, nearest.weights.y / sum, nearest.weights.z / sum, depth);
    }
    hits[pixel] = hit;
}
