// Whether any triangle blocks a ray from a triangle towards a light. As in trace.glsl nothing is divided, and decisions
// are bit for bit the same on every device.
//
// A triangle blocks when the ray passes through it, and one of its corners lies in front of the plane of the triangle
// that the ray starts from, for certain: what lies behind that plane or in it, the triangle itself, flat or convex
// neighbours and coincident sheets among it, cannot block a ray that leaves to the front. A light that has a place has
// to lie beyond the blocking triangle, for certain: one in a surface is not blocked by that surface.

const uint FREE = 0, BLOCKED = 1;

// From `origin` along `direction`, up to the light at `light`, or without end if it is `far`; `own` is the plane that
// the ray starts from, and `side` the side on which it leaves. If it is not `wanted`, no ray is followed. With
// `others`, the `spared` triangles (first, number) block nothing, and those behind that plane do.
uint occlusion(vec3 origin, vec3 direction, bool far, vec3 light, uint self, Plane own, float side, bool wanted,
               uvec2 spared, bool others) {
    Sight ray = sight(direction);
    Nearest limit = Nearest(far ? NONE : 0, vec3(0), ray.square, ray.scale); // the light: `along` / `scale`
    uint end = object_params[0].scene_nodes, node = wanted ? 0 : end;
    while (node < end) {
        // On to the next triangle whose box the ray meets. Then that triangle.
        uint face = NONE;
        while (face == NONE && node < end) {
            Bounds box = placed_bounds[node];
            bool met = meets(box.low, box.high, origin, ray, limit);
            if (met) face = box.face;
            node = met && face == NONE ? node + 1 : box.next;
        }
        if (face != NONE) {
            uvec3 corner = triangles[face];
            vec3 pa = placed_positions[corner.x], pb = placed_positions[corner.y], pc = placed_positions[corner.z];
            precise vec3 a = pa - origin;
            precise vec3 b = pb - origin;
            precise vec3 c = pc - origin;
            Nearest found = pierce(ray, a, b, c);
            Plane plane = plane_of(pa, pb, pc);
            float through = dot3(direction, plane.normal) > 0.0 ? 1.0 : -1.0;
            bool nearer = far || beyond(plane, light, through);
            bool counts = others ? face - spared.x >= spared.y : face != self;
            bool front = others || beyond(own, pa, side) || beyond(own, pb, side) || beyond(own, pc, side);
            if (counts && found.face != NONE && found.numerator > 0.0 && nearer && front) node = end + 1;
        }
    }
    return node < end ? UNFINISHED : node > end ? BLOCKED : FREE;
}
