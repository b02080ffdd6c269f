// Whether any triangle blocks a ray from a triangle towards a light. As in trace.glsl nothing is divided, and decisions
// are bit for bit the same on every device.
//
// A triangle blocks when the ray passes through it, and one of its corners lies in front of the plane of the triangle
// that the ray starts from, for certain: what lies behind that plane or in it, the triangle itself, flat or convex
// neighbours and coincident sheets among it, cannot block a ray that leaves to the front. A light that has a place has
// to lie beyond the blocking triangle, for certain: one in a surface is not blocked by that surface.

const uint FREE = 0, BLOCKED = 1;

// A ray from `origin` along `direction`, up to the light at `light`, or without end if it is `far`.
struct Ask {
    uint face; // the triangle that it starts from
    vec3 origin, direction, light;
    bool far;
    Plane own;    // the plane of that triangle
    float side;   // the side of that plane on which it leaves
    bool wanted;  // if not, no ray is followed
    bool others;  // the `spared` triangles (first, number) block nothing; all others may, behind that plane too
    uvec2 spared;
};

// The light's distance along a ray: `along` / `scale`.
Nearest light_of(Sight ray, bool far) { return Nearest(far ? NONE : 0, vec3(0), ray.square, ray.scale); }

// Whether a triangle that the ray passes through blocks it.
bool blocks(Ask ask, uint face, vec3 a, vec3 b, vec3 c) {
    Plane plane = plane_of(a, b, c);
    float through = dot3(ask.direction, plane.normal) > 0.0 ? 1.0 : -1.0;
    bool nearer = ask.far || beyond(plane, ask.light, through);
    bool counts = ask.others ? face - ask.spared.x >= ask.spared.y : face != ask.face;
    bool front = ask.others || beyond(ask.own, a, ask.side) || beyond(ask.own, b, ask.side) ||
                 beyond(ask.own, c, ask.side);
    return counts && nearer && front;
}

// Whether the ray passes through a triangle, in front of its origin.
bool passes(Ask ask, Sight ray, vec3 corner_a, vec3 corner_b, vec3 corner_c) {
    precise vec3 a = corner_a - ask.origin;
    precise vec3 b = corner_b - ask.origin;
    precise vec3 c = corner_c - ask.origin;
    Nearest found = pierce(ray, a, b, c);
    return found.face != NONE && found.numerator > 0.0;
}

uint occlusion(Ask ask) {
    Sight ray = sight(ask.direction);
    Nearest limit = light_of(ray, ask.far);
    uint end = object_params[0].scene_nodes, node = ask.wanted ? 0 : end;
    while (node < end) {
        // Goes on to the next triangle whose box the ray meets, then tests that triangle.
        uint face = NONE;
        while (face == NONE && node < end) {
            Bounds box = placed_bounds[node];
            bool met = meets(box.low, box.high, ask.origin, ray, limit);
            if (met) face = box.face;
            node = met && face == NONE ? node + 1 : box.next;
        }
        if (face != NONE) {
            uvec3 corner = triangles[face];
            vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
            if (passes(ask, ray, a, b, c) && blocks(ask, face, a, b, c)) node = end + 1;
        }
    }
    return node < end ? UNFINISHED : node > end || !ask.wanted ? BLOCKED : FREE;
}
