// Factors, the bits of powers of two, that make the largest light of a triangle 2^30 to 2^31.
uvec3 factors(uvec3 most) {
    return (284u - (clamp(most >> 23, 31u, 254u))) << 23;
}
