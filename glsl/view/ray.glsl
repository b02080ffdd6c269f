// The direction from the eye through the current sample of a pixel. Any length will do, which spares divisions.
vec3 ray(uint pixel) {
    uint width = camera[0].width, height = camera[0].height;
    uint column = pixel % width, row = pixel / width;
    float w = float(width), h = float(height);
    precise float x = (float(2 * column + 1) + camera[0].shift_x - w) * h;
    precise float y = (h - (float(2 * row + 1) + camera[0].shift_y)) * w;
    precise float z = w * h;
    precise vec3 direction = z * camera[0].forward + x * camera[0].right + y * camera[0].up;
    return direction;
}
