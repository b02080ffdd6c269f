//! A texture at one point, bilinear between the centres of texels.

use glam::{DVec2, DVec3};

use crate::layout::{Buffers, ObjectParams, TEXTURE_LEAVES, WRAP_CLAMP, WRAP_REPEAT};
use crate::state::{State, wide};

/// Why no light is multiplied by a texture on this side, `TEXTURE_ENTERS` or `TEXTURE_LEAVES`, if none is.
#[must_use]
pub fn untextured(state: &State, side: u32) -> Option<&'static str> {
    let sides = state.data.object_params.iter().fold(0, |sides, params| sides | params.texture_side);
    match sides {
        0 => Some("no material has a texture"),
        sides if sides & side != 0 => None,
        TEXTURE_LEAVES => Some("the texture is for light that leaves"),
        _ => Some("the texture is for light that enters"),
    }
}

/// Which texel of a row of `count` serves as texel `i`; `wrap` is one of `object_params.texture_wrap`.
#[must_use]
pub fn texel(i: i64, count: u32, wrap: u32) -> u32 {
    let last = i64::from(count) - 1;
    let k = match wrap {
        WRAP_REPEAT => i.rem_euclid(last + 1),
        WRAP_CLAMP => i.clamp(0, last),
        _ => {
            let k = i.rem_euclid(2 * last + 2);
            k.min(2 * last + 1 - k)
        }
    };
    k as u32
}

/// Factors of an object's texture at a point: (0, 0) is the upper left corner of the texture, (1, 1) the lower right
/// one.
#[must_use]
pub fn factor(params: &ObjectParams, texels: &[[f32; 3]], place: DVec2) -> DVec3 {
    look(texels, params.texture_first, params.texture_size, params.texture_wrap, place)
}

/// Factors at a point of the texture that has this first texel, size and wrap modes.
#[must_use]
pub fn look(texels: &[[f32; 3]], first: u32, [width, height]: [u32; 2], wrap: [u32; 2], place: DVec2) -> DVec3 {
    let at = place * DVec2::new(width.into(), height.into()) - 0.5;
    let (left, top) = (at.x.floor(), at.y.floor());
    let row = |row: i64| {
        let first = first + texel(row, height, wrap[1]) * width;
        let value = |column: i64| wide(texels[(first + texel(column, width, wrap[0])) as usize]);
        value(left as i64).lerp(value(left as i64 + 1), at.x - left)
    };
    row(top as i64).lerp(row(top as i64 + 1), at.y - top)
}

/// The texture coordinates of a point of a triangle, `u` and `v` being the weights of the second and third corner.
#[must_use]
pub fn place(data: &Buffers, face: usize, u: f64, v: f64) -> DVec2 {
    let corners = &data.corner_uvs[face];
    let [a, b, c] = [corners.a, corners.b, corners.c].map(|[x, y]| DVec2::new(x.into(), y.into()));
    (1.0 - u - v) * a + u * b + v * c
}

#[cfg(test)]
mod tests {
    use crate::layout::WRAP_MIRROR;
    use crate::lighting::texture::*;

    #[test]
    fn texels_go_on_beyond_the_edges() {
        let row = |wrap: u32| (-4..7).map(|i| texel(i, 3, wrap)).collect::<Vec<_>>();
        assert_eq!(row(WRAP_REPEAT), [2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        assert_eq!(row(WRAP_CLAMP), [0, 0, 0, 0, 0, 1, 2, 2, 2, 2, 2]);
        assert_eq!(row(WRAP_MIRROR), [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0]);
    }

    #[test]
    fn between_centres_a_texture_is_linear() {
        let params = ObjectParams { texture_size: [2, 2], texture_first: 1, ..ObjectParams::default() };
        let texels = [0.9, 0.0, 0.4, 0.8, 1.0].map(|x| [x; 3]).to_vec();
        let mut data = Buffers { object_params: vec![params], texels, ..Buffers::default() };
        let mut at = |x: f64, y: f64, wrap: [u32; 2]| {
            data.object_params[0].texture_wrap = wrap;
            factor(&data.object_params[0], &data.texels, DVec2::new(x, y)).x
        };
        // Centres; 3/4 of the first and 1/4 of the second in each direction; over the edge.
        let cases = [
            (0.25, 0.25, 0, 0.0),
            (0.75, 0.25, 0, 0.4),
            (0.25, 0.75, 0, 0.8),
            (0.375, 0.375, 0, 0.5625 * 0.0 + 0.1875 * (0.4 + 0.8) + 0.0625),
            (0.0, 0.25, 0, 0.2),
            (0.0, 0.25, 1, 0.0),
            (0.0, 0.25, 2, 0.0),
            (1.25, 0.25, 0, 0.0),
            (1.25, 0.25, 1, 0.4),
            (1.25, 0.25, 2, 0.4),
            (1.5, -0.25, 2, 0.2),
        ];
        for (x, y, wrap, expected) in cases {
            let found = at(x, y, [wrap; 2]);
            assert!((found - expected).abs() < 1e-7, "({x}, {y}), {wrap}: {found}, not {expected}");
        }
        // A mode for each direction.
        assert_eq!([[0, 1], [1, 0]].map(|wrap| at(1.25, 1.25, wrap)), [0.8, 0.4].map(|x| f64::from(x as f32)));
    }
}
