// Sine and cosine in additions, multiplications and comparisons: the same bits on every device.

// Sine of an angle of up to a quarter of a turn.
float quarter(float x) {
    precise float z = x * x;
    precise float sum = SINE[6];
    sum = sum * z + SINE[5];
    sum = sum * z + SINE[4];
    sum = sum * z + SINE[3];
    sum = sum * z + SINE[2];
    sum = sum * z + SINE[1];
    sum = sum * z + SINE[0];
    precise float sine = sum * x;
    return sine;
}

// Sine and cosine of an angle in turns.
vec2 turn(float turns) {
    precise float x = turns - floor(turns + 0.5);
    precise float part = x < 0.0 ? -0.5 - x : 0.5 - x;
    precise float left = 0.25 - abs(x);
    return vec2(quarter(abs(x) > 0.25 ? part : x), quarter(left));
}
