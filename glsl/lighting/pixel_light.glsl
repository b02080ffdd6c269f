// A light as one pixel sees it in one sample. Areas and environments are seen at points of a sequence that fills the
// square evenly (R2, by the plastic number), shifted for each pixel: no two neighbours see the same ones, and further
// samples fill the gaps. The same bits on every device.

// The point of the unit square for a light's number in this pixel and sample.
vec2 square_point(Light light, uint pixel) {
    uint point = camera[0].sample_number * light.of + light.number;
    uvec4 shift = random4(pixel, light.kind, 0, 0);
    return vec2(unit_random(shift.x + point * SQUARE_STEPS[0]), unit_random(shift.y + point * SQUARE_STEPS[1]));
}

// `normal` is the surface's, of any length. Rays to the environment are drawn by the cosine about it.
Light pixel_light(uint number, uint pixel, vec3 normal) {
    Light light = pixel_lights[number];
    bool area = light.kind == LIGHT_AREA || light.kind == LIGHT_AREA_BOTH;
    if (area || light.kind == LIGHT_SKY_RAY) {
        vec2 square = square_point(light, pixel);
        float u = square.x, v = square.y;
        precise float across = u - 0.5, along = v - 0.5;
        precise vec3 place = light.place + (across * light.edge_u + along * light.edge_v);
        precise float left = 1.0 - u;
        if (!area) place = about(unit_of(normal), root_of(left), v);
        light.place = place;
    }
    return light;
}
