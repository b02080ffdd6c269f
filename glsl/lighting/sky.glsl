// The environment's radiance from one direction: its image, linear between the centres of four pixels.

const float PI = 3.14159265358979;

// The angle of (x, y), -pi to pi. Vulkan allows a driver's own function an error of 4096 units in the last place; this
// is a series for half the angle, within an eighth of a turn, in its tangent; its first omitted term is 2e-8.
float angle(float y, float x) {
    float a = min(abs(x), abs(y)), b = max(abs(x), abs(y));
    float t = a / max(b + sqrt(a * a + b * b), 1e-30), s = t * t;
    float series = 1.0 / 11.0 - s * (1.0 / 13.0 - s * (1.0 / 15.0));
    series = 1.0 - s * (1.0 / 3.0 - s * (1.0 / 5.0 - s * (1.0 / 7.0 - s * (1.0 / 9.0 - s * series))));
    float whole = 2.0 * t * series;
    whole = abs(y) > abs(x) ? 0.5 * PI - whole : whole;
    whole = x < 0.0 ? PI - whole : whole;
    return y < 0.0 ? -whole : whole;
}

// The radiance from a direction of any length but 0; columns go round, rows end at the poles.
vec3 sky_toward(vec3 direction) {
    uint width = object_params[0].sky.x, height = object_params[0].sky.y;
    float turns = angle(direction.x, -direction.z) / (2.0 * PI) + object_params[0].sky_turn;
    float polar = angle(length(direction.xz), direction.y);
    float x = float(width) * (turns - floor(turns)) - 0.5;
    float y = clamp(float(height) * polar / PI - 0.5, 0.0, float(height - 1));
    uint left = uint(int(floor(x)) + int(width)) % width, right = (left + 1) % width;
    uint top = min(uint(y), height - 1), bottom = min(top + 1, height - 1);
    vec3 above = mix(sky[top * width + left], sky[top * width + right], x - floor(x));
    vec3 below = mix(sky[bottom * width + left], sky[bottom * width + right], x - floor(x));
    return mix(above, below, y - floor(y));
}
