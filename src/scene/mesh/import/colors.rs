//! Colours of vertices as a texture: every triangle has four texels of its own, between which the texture is
//! interpolated as the colours are.

use super::Texels;
use crate::error::Input;
use crate::scene::range::Checked;

/// Maximum number of triangles with colours: four texels of each almost fill the largest texture.
pub(super) const MOST: usize = 2_000_000;

/// The note on a file whose colours are not used.
pub(super) const LEFT_OUT: &str = "ignored: the colours of the vertices; texture = \"mesh\" in the material shows them";

/// Squares of four texels in a row.
fn columns(triangles: usize) -> usize {
    (triangles as f64).sqrt().ceil().max(1.0) as usize
}

/// Width and height in texels.
fn size(triangles: usize) -> [usize; 2] {
    let columns = columns(triangles);
    [2 * columns, 2 * triangles.div_ceil(columns).max(1)]
}

/// Texture coordinates of the corners of each of so many triangles: the middles of three of its texels.
pub(super) fn corners(triangles: usize) -> Vec<[[f64; 2]; 3]> {
    let ([width, height], columns) = (size(triangles).map(|side| side as f64), columns(triangles));
    let places = |triangle: usize| {
        let [x, y] = [triangle % columns, triangle / columns].map(|place| 2.0 * place as f64 + 0.5);
        [[x, y], [x + 1.0, y], [x, y + 1.0]].map(|[x, y]| [x / width, 1.0 - y / height])
    };
    (0..triangles).map(places).collect()
}

/// The texture of triangles whose corners have these colours; an error if there are more than [`MOST`].
pub(super) fn checked(colors: impl ExactSizeIterator<Item = [[f32; 3]; 3]>) -> Checked<Texels> {
    if colors.len() > MOST {
        let fault = Input::new("too many triangles for colours of their vertices").found(colors.len());
        return Err(fault.expected(format!("at most {MOST}")));
    }
    Ok(texture(&colors.collect::<Vec<_>>()))
}

/// The texture of triangles whose corners have these colours, each from 0 to 1, r g b, linear.
fn texture(colors: &[[[f32; 3]; 3]]) -> Texels {
    let ([width, height], columns) = (size(colors.len()), columns(colors.len()));
    let mut texels = vec![[1.0; 3]; width * height];
    for (triangle, [a, b, c]) in colors.iter().enumerate() {
        let first = 2 * (triangle / columns) * width + 2 * (triangle % columns);
        // The texel beyond the middle of the longest side: its weight within the triangle is at most a quarter.
        let beyond = [0, 1, 2].map(|k| (b[k] + c[k] - a[k]).clamp(0.0, 1.0));
        (texels[first], texels[first + 1]) = (*a, *b);
        (texels[first + width], texels[first + width + 1]) = (*c, beyond);
    }
    ([width as u32, height as u32], texels)
}

/// Linear light of an sRGB value from 0 to 1.
pub(super) fn linear(x: f64) -> f32 {
    let light = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    light as f32
}

/// The nearest number from 0 to 1; 0 for NaN.
pub(super) fn share(x: f64) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_has_each_triangles_colours_at_its_corners() {
        let colors: Vec<[[f32; 3]; 3]> = (0..7).map(|k| [0.0, 0.1, 0.2].map(|x| [x + 0.1 * k as f32; 3])).collect();
        let ([width, height], texels) = texture(&colors);
        assert_eq!((width, height, texels.len()), (6, 6, 36));
        for (places, colors) in corners(7).iter().zip(&colors) {
            for ([u, v], color) in places.iter().zip(colors) {
                let (x, y) = (u * 6.0 - 0.5, (1.0 - v) * 6.0 - 0.5);
                assert!((x - x.round()).abs() < 1e-9 && (y - y.round()).abs() < 1e-9, "in the middle of a texel");
                assert_eq!(texels[y.round() as usize * 6 + x.round() as usize], *color);
            }
        }
        assert!(size(MOST).iter().product::<usize>() <= 1 << 23);
        assert_eq!((linear(0.0), linear(1.0)), (0.0, 1.0));
    }
}
