// Whether rays of a team of invocations are blocked, by one walk through the wide tree for all of them. Each invocation
// tests another child of a node against the shaft that holds their rays; then all test the same triangles, each against
// its own ray. Which triangles are tested decides nothing: they are at least those whose boxes a ray meets.

const uint TEAMS = TEAM_GROUP / LEAST_TEAM;
// Triangles that wait for their test, and wide nodes that wait to be opened.
const uint LIST = 32, LISTS = TEAMS * LIST, STACKS = LISTS + TEAMS * WIDE_DEPTH;
// The last part takes what is not kept, so that all invocations store without a branch.
shared uint pool[STACKS + TEAM_GROUP];

uint from_other(uint v, uint from) { return SHUFFLES != 0 ? subgroupShuffle(v, from) : v; }

// The bits, the smallest and the largest numbers of the whole team.
uint joined(uint v) {
    uint self = gl_SubgroupInvocationID;
    if (TEAM > 1) v |= from_other(v, self ^ 1);
    if (TEAM > 2) v |= from_other(v, self ^ 2);
    if (TEAM > 4) v |= from_other(v, self ^ 4);
    return v;
}

vec3 lowest(vec3 v) {
    uint self = gl_SubgroupInvocationID;
    if (TEAM > 1) v = min(v, shuffled(v, self ^ 1));
    if (TEAM > 2) v = min(v, shuffled(v, self ^ 2));
    if (TEAM > 4) v = min(v, shuffled(v, self ^ 4));
    return v;
}

// FREE, BLOCKED or UNFINISHED, of the ray of each invocation; `lane` is its place in the group.
uint shaft(Ask ask, uint lane) {
    uint mine = lane % TEAM, team = lane / TEAM, base = gl_SubgroupInvocationID - mine;
    uint list = team * LIST, stack = LISTS + team * WIDE_DEPTH, waste = STACKS + lane;

    // The rays lie within a box of origins that is moved to the light or, as they converge there, within less.
    vec3 low = lowest(ask.wanted ? ask.origin : vec3(NO_BOX));
    vec3 high = -lowest(ask.wanted ? -ask.origin : vec3(NO_BOX));
    bool any = low.x <= high.x;
    precise vec3 middle = any ? 0.5 * (low + high) : vec3(0), around = any ? 0.5 * (high - low) * 1.00001 : vec3(0);
    precise vec3 direction = ask.far ? ask.light : ask.light - middle;
    Sight axis = sight(direction), ray = sight(ask.direction);
    Nearest limit = light_of(axis, ask.far);

    bool free = ask.wanted, left = false;
    uint top = 0, tops = any ? object_params[0].wide_tops : 0;
    while (top > 0 || tops > 0) {
        if (top == 0) {
            --tops;
            pool[stack] = WIDE * tops;
            top = 1;
        }
        uint count = 0;
        while (top > 0 && count + WIDE <= LIST) {
            --top;
            uint node = pool[stack + top];
            // Of each child: whether it is met, in the first half of the word where it is a triangle.
            uint met = 0;
            Bounds box[WIDE / LEAST_TEAM];
            for (uint k = 0; k < WIDE / TEAM; ++k) {
                uint child = mine + k * TEAM;
                box[k] = wide_boxes[node + child];
                bool meet = meets(box[k].low - around, box[k].high + around, middle, axis, limit);
                met |= meet ? 1u << (child + (box[k].face != NONE ? 0 : 16)) : 0;
            }
            met = joined(met);
            for (uint k = 0; k < WIDE / TEAM; ++k) {
                uint child = mine + k * TEAM, before = (0x10001u << child) - 0x10001u & met;
                bool leaf = box[k].face != NONE;
                uint place = leaf ? list + count + bitCount(before & 0xffff) : stack + top + bitCount(before >> 16);
                bool meet = (met >> child & 0x10001u) != 0;
                pool[meet ? place : waste] = leaf ? box[k].face : box[k].next;
            }
            count += bitCount(met & 0xffff);
            top += bitCount(met >> 16);
        }

        uint at = 0;
        for (; at < count; at += TEAM) {
            uint face = pool[list + min(at + mine, count - 1)];
            uvec3 corner = triangles[face];
            vec3 a = placed_positions[corner.x], b = placed_positions[corner.y], c = placed_positions[corner.z];
            uint hits = 0;
            for (uint k = 0; k < TEAM; ++k) {
                uint from = base + k;
                bool hit = passes(ask, ray, shuffled(a, from), shuffled(b, from), shuffled(c, from));
                hits |= hit ? 1u << k : 0;
            }
            // Few rays pass through a triangle; all invocations stay while any has one to look at.
            hits = free ? hits : 0;
            while (joined(hits) != 0) {
                uint from = base + (hits != 0 ? findLSB(hits) : 0);
                bool block = blocks(ask, from_other(face, from), shuffled(a, from), shuffled(b, from), shuffled(c, from));
                free = free && !(hits != 0 && block);
                hits = free ? hits & (hits - 1) : 0;
            }
            left = left || hits != 0;
        }
        left = left || at < count;
        if (joined(uint(free)) == 0) {
            top = 0;
            tops = 0;
        }
    }
    return left || top > 0 || tops > 0 ? UNFINISHED : free ? FREE : BLOCKED;
}
