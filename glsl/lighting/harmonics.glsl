// The environment by the nine spherical harmonics of degree 0 to 2, real and orthonormal, in x, y, z of a unit vector.

vec3 degree_0() {
    return 0.28209479 * harmonics[0];
}

vec3 degree_1(vec3 n) {
    return 0.48860251 * (n.x * harmonics[1] + n.y * harmonics[2] + n.z * harmonics[3]);
}

vec3 degree_2(vec3 n) {
    vec3 mixed = n.y * n.z * harmonics[4] + n.z * n.x * harmonics[5] + n.x * n.y * harmonics[6];
    vec3 axial = 0.31539157 * (3.0 * n.y * n.y - 1.0) * harmonics[7];
    return 1.09254843 * mixed + axial + 0.54627421 * (n.x * n.x - n.z * n.z) * harmonics[8];
}

// Radiance from a direction.
vec3 sky_radiance(vec3 n) {
    return max(vec3(0), degree_0() + degree_1(n) + degree_2(n));
}

// Light from all directions that enters a surface with this normal.
vec3 sky_irradiance(uint object, vec3 n) {
    vec3 low = object_params[object].zonal_0 * degree_0() + object_params[object].zonal_1 * degree_1(n);
    return max(vec3(0), low + object_params[object].zonal_2 * degree_2(n));
}
