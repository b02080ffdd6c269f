// Rays of a team of invocations go through the wide tree together: each invocation tests another child of a node
// against the shaft that holds all their rays; the triangles that it meets are listed, and then all test the same ones,
// each against its own ray. The result does not depend on which triangles are listed: all that could change it are
// among them. A shaft may hold many that no ray comes near, such as those of a dense mesh between two pixels' rays:
// after MOST_LISTED, rays that need more go alone. Or the team has one ray, which is the shaft, and each invocation
// tests other triangles of the list.
//
// The includer says what is in the shaft. All invocations of a team take the same branches, those without a ray too.

bool in_shaft(vec3 low, vec3 high);

const uint MOST_LISTED = 1024;
// A team has LEAST_TEAM or WIDE invocations; rays that go alone need no room.
const uint TEAMS = TEAM_GROUP / (LEAST_TEAM + TEAM / WIDE * (WIDE - LEAST_TEAM));
// LIST triangles wait for their test, DEPTH wide nodes to be opened: `hierarchy::wide` says at most 73.
const uint LIST = 32, DEPTH = 80, LISTS = TEAMS * LIST, STACKS = LISTS + TEAMS * DEPTH;
// The last part takes values that are not kept, so that all invocations store without a branch.
shared uint pool[STACKS + TEAM_GROUP];

// An invocation's place in its group, and its team's share of the pool.
struct Place { uint lane, mine, base, list, stack; };

Place place_in_team() {
    uint place = lane(), mine = place % TEAM, team = place / TEAM;
    return Place(place, mine, SUBGROUP_LANE - mine, team * LIST, LISTS + team * DEPTH);
}

// Whether the device has teams of this size.
bool in_teams() { return TEAM > 1 && SUBGROUP_SIZE >= TEAM; }

// All bits of the whole team, or-ed.
uint joined(uint v) {
    uint self = SUBGROUP_LANE;
    if (TEAM > 1) v |= shuffled(v, self ^ 1);
    if (TEAM > 2) v |= shuffled(v, self ^ 2);
    if (TEAM > 4) v |= shuffled(v, self ^ 4);
    return v;
}

// The least values in the whole team, by component.
vec3 least(vec3 v) {
    uint self = SUBGROUP_LANE;
    if (TEAM > 1) v = min(v, shuffled(v, self ^ 1));
    if (TEAM > 2) v = min(v, shuffled(v, self ^ 2));
    if (TEAM > 4) v = min(v, shuffled(v, self ^ 4));
    return v;
}

// How many wide nodes wait, how many whole trees after them, and how many triangles were listed.
struct Waiting { uint nodes, tops, listed; };

bool waits(Waiting way) { return way.nodes > 0 || way.tops > 0; }
bool goes_on(Waiting way) { return waits(way) && way.listed < MOST_LISTED; }

// Lists triangles until the list is full or nothing waits; returns their number.
uint list_triangles(Place self, inout Waiting way) {
    uint count = 0, top = NONE;
    if (way.nodes == 0) {
        --way.tops;
        top = WIDE * way.tops;
        way.nodes = 1;
    }
    while (way.nodes > 0 && count + WIDE <= LIST) {
        --way.nodes;
        uint node = top != NONE ? top : pool[self.stack + way.nodes];
        top = NONE;
        // Each child in the shaft sets a bit: of the lower half if it is a triangle, else of the upper half.
        uint met = 0;
        Bounds box[WIDE / LEAST_TEAM];
        for (uint k = 0; k < WIDE / TEAM; ++k) {
            uint child = self.mine + k * TEAM;
            box[k] = wide_boxes[node + child];
            met |= in_shaft(box[k].low, box[k].high) ? 1u << (child + (box[k].face != NONE ? 0 : 16)) : 0;
        }
        met = joined(met);
        // All have read what some overwrite: the node's place, and the list of before.
        exchange_in_subgroup();
        for (uint k = 0; k < WIDE / TEAM; ++k) {
            uint child = self.mine + k * TEAM, before = (0x10001u << child) - 0x10001u & met;
            bool leaf = box[k].face != NONE;
            uint place = leaf ? self.list + count + bitCount(before & 0xffff)
                              : self.stack + way.nodes + bitCount(before >> 16);
            bool meet = (met >> child & 0x10001u) != 0;
            pool[meet ? place : STACKS + self.lane] = leaf ? box[k].face : box[k].next;
        }
        count += bitCount(met & 0xffff);
        way.nodes += bitCount(met >> 16);
        exchange_in_subgroup();
    }
    way.listed += count;
    return count;
}
