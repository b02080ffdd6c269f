// The corners of a triangle, turned so that this vertex is the first.
uvec3 turned(uvec3 corner, uint vertex) {
    return corner.x == vertex ? corner : corner.y == vertex ? corner.yzx : corner.zxy;
}
