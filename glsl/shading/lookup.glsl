// The table of the CDRF, bilinear between its entries: SIDE x SIDE of them, cosines from -1 to 1, sigmas from 0 to
// CDRF_WIDEST. A cell is one word: the value at its first corner, and the changes across, up and both, in steps of
// 1 / (31 (SIDE - 1)).
vec3 lookup(float c, vec3 sigma) {
    const float last = float(SIDE - 1);
    float across = clamp(0.5 * last * c + 0.5 * last, 0.0, last), column = min(floor(across), last - 1.0);
    vec3 up = clamp(sigma * (last / CDRF_WIDEST), vec3(0), vec3(last)), row = min(floor(up), vec3(last - 1.0));
    // Whole numbers below 2^24.
    ivec3 at = ivec3(row * last + column);
    ivec3 cell = ivec3(cdrf_cells[at.x], cdrf_cells[at.y], cdrf_cells[at.z]);
    vec3 first = vec3(cell & 0x1fff), x = vec3(cell >> 13 & 0x3f), both = vec3(cell << 7 >> 26), y = vec3(cell >> 25);
    float share = across - column;
    return first * (1.0 / 8192.0) + (share * x + (up - row) * (y + share * both)) * (1.0 / (31.0 * last));
}
