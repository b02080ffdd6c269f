// The table of the CDRF, linear between its entries: SIDE x SIDE of them, cosines from -1 to 1, sigmas from 0 to 3.5.
vec3 lookup(float c, vec3 sigma) {
    float last = float(SIDE - 1), across = clamp(0.5 * c + 0.5, 0.0, 1.0) * last, column = min(floor(across), last - 1.0);
    vec3 up = clamp(sigma / 3.5, vec3(0), vec3(1)) * last, row = min(floor(up), vec3(last - 1.0));
    uvec3 cell = uvec3(row) * (SIDE - 1) + uint(column);
    vec4 r = cdrf_cells[cell.x], g = cdrf_cells[cell.y], b = cdrf_cells[cell.z];
    float x = across - column;
    vec3 low = mix(vec3(r.x, g.x, b.x), vec3(r.y, g.y, b.y), x), high = mix(vec3(r.z, g.z, b.z), vec3(r.w, g.w, b.w), x);
    return mix(low, high, up - row);
}
