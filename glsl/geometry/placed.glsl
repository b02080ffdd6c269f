// From an object's own frame into the scene. Additions and multiplications in a fixed order only; a point of an object
// that is neither turned nor shifted stays where it is, to the last bit.

vec3 turned(uint object, vec3 v) {
    vec3 x = object_params[object].turn_x, y = object_params[object].turn_y, z = object_params[object].turn_z;
    precise vec3 sum = vec3(x.x * v.x + x.y * v.y + x.z * v.z, y.x * v.x + y.y * v.y + y.z * v.z,
                            z.x * v.x + z.y * v.y + z.z * v.z);
    return sum;
}

vec3 placed(uint object, vec3 point) {
    precise vec3 sum = turned(object, point) + object_params[object].shift;
    return sum;
}
