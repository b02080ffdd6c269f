// The table of the CDRF, linear between its entries: SIDE x SIDE of them, cosines from -1 to 1, sigmas from 0 to 3.5.
vec3 lookup(float c, vec3 sigma) {
    const float last = float(SIDE - 1);
    float across = clamp(0.5 * last * c + 0.5 * last, 0.0, last), column = min(floor(across), last - 1.0);
    vec3 up = clamp(sigma * (last / 3.5), vec3(0), vec3(last)), row = min(floor(up), vec3(last - 1.0));
    // Whole numbers below 2^24.
    ivec3 cell = ivec3(row * last + column);
    vec4 r = cdrf_cells[cell.x], g = cdrf_cells[cell.y], b = cdrf_cells[cell.z];
    float x = across - column;
    vec3 low = mix(vec3(r.x, g.x, b.x), vec3(r.y, g.y, b.y), x), high = mix(vec3(r.z, g.z, b.z), vec3(r.w, g.w, b.w), x);
    return mix(low, high, up - row);
}
