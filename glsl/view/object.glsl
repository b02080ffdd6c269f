// The object of a triangle.
uint object_of(uint face) {
    uint object = 0;
    for (uint k = 1; k < OBJECTS; ++k) object += uint(face >= object_params[k].first_face);
    return object;
}
