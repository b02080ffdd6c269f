//! A material's texture, as the stages `texture_in` and `texture_out` read it.

use glam::DVec2;

use crate::layout::{CornerUvs, ObjectParams};
use crate::layout::{TEXTURE_ENTERS as ENTRY, TEXTURE_LEAVES as EXIT};
use crate::scene::{Material, Mesh, Side, Wrap};
use crate::state::options::{Goal, Options};
use crate::state::{Local, State};

/// Adds a texture to the state, and the texture coordinates of the corners, which depth maps use too. `faces` is the
/// mesh triangle of each triangle of the state. Does nothing for a mesh without texture coordinates.
pub(crate) fn texture(state: &mut State, material: &Material, mesh: &Mesh, faces: &[u32]) {
    let (texture, layers) = (material.texture.as_ref(), material.layers.as_ref().filter(|layers| layers.map.mapped));
    let spread = material.sigma_0_texture.as_ref();
    let wrap = texture.or(spread).map(|texture| texture.wrap).or(layers.map(|layers| [layers.map.wrap; 2]));
    // A blur over texture coordinates needs them even without a texture.
    let wrap = wrap.or((state.method.local == Some(Local::Blur)).then_some([Wrap::Repeat; 2]));
    let (Some(wrap), Some(uvs)) = (wrap, &mesh.uvs) else { return };
    let data = &mut state.data;
    let period = wrap.map(Wrap::period);
    let places = faces.iter().map(|&face| uvs.get(face as usize).map_or(CornerUvs::default(), |uvs| near(uvs, period)));
    data.corner_uvs = places.collect();
    let params = &mut data.object_params[0];
    params.texture_wrap = wrap.map(Wrap::code);
    if let Some(spread) = spread {
        (params.sigma_0_size, params.sigma_0_first) = (spread.size, data.texels.len() as u32);
        data.texels.extend(spread.texels.iter());
    }
    let Some(texture) = texture else { return };
    params.texture_side = match texture.side {
        Side::Entry => ENTRY,
        Side::Exit => EXIT,
        Side::Both => ENTRY | EXIT,
    };
    params.texture_size = texture.size;
    params.texture_first = data.texels.len() as u32;
    let root = |x: f32| if texture.side == Side::Both { x.sqrt() } else { x };
    data.texels.extend(texture.texels.iter().map(|texel| texel.map(root)));
}

/// A triangle's texture coordinates from the upper left corner, with whole periods removed.
fn near(uvs: &[[f64; 2]; 3], period: [Option<f64>; 2]) -> CornerUvs {
    let down = uvs.map(|[u, v]| [u, 1.0 - v]);
    let least = |axis: usize| down.iter().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
    let off = [0, 1].map(|axis| period[axis].map_or(0.0, |period| (least(axis) / period).floor() * period));
    let [a, b, c] = down.map(|place| [0, 1].map(|axis| (place[axis] - off[axis]) as f32));
    CornerUvs { a, b, c }
}

/// Texels whose centres lie in a triangle, counted from the upper left, with whole repetitions removed, and the
/// weights of its corners there.
pub(crate) fn texels([width, height]: [u32; 2], uvs: &[[f64; 2]; 3]) -> Vec<(usize, [f64; 3])> {
    let size = DVec2::new(width.into(), height.into());
    let [a, b, c] = uvs.map(|place| DVec2::from_array(place) * size - 0.5);
    let area = (b - a).perp_dot(c - a);
    if area == 0.0 {
        return Vec::new();
    }
    let (low, high) = (a.min(b).min(c).ceil(), a.max(b).max(c).floor());
    let mut found = Vec::new();
    for y in low.y as i64..=high.y as i64 {
        for x in low.x as i64..=high.x as i64 {
            let p = DVec2::new(x as f64, y as f64);
            let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)].map(|w| w / area);
            if weights.iter().all(|&w| w >= -1e-9) {
                let [x, y] = [x.rem_euclid(width.into()), y.rem_euclid(height.into())];
                found.push(((y * i64::from(width) + x) as usize, weights));
            }
        }
    }
    found
}

/// Drops a texture, and the tones of a picture, if a frame with these options never reads them.
pub(crate) fn drop_unseen(state: &mut State, options: Options) {
    if options.goal == Goal::Radiosity {
        state.data.tones = Vec::new();
    }
    let entry = state.data.object_params.iter().any(|params| params.texture_side & ENTRY != 0);
    if options.goal == Goal::Radiosity && !entry {
        (state.data.texels, state.data.corner_uvs) = Default::default();
    }
}

/// The largest factor of the entry texture in each channel, or 1 where there is no texture.
pub(crate) fn brightest_entry(params: &ObjectParams, texels: &[[f32; 3]]) -> [f64; 3] {
    let largest = |c: usize| entering(params, texels).iter().map(|texel| texel[c]).fold(0.0, f32::max);
    [0, 1, 2].map(|c| largest(c).into())
}

/// Whether the entry texture keeps the ratio of two channels: their texels differ by the ratio of their largest only.
pub(crate) fn keeps_ratio(
    params: &ObjectParams,
    texels: &[[f32; 3]],
    largest: [f64; 3],
    c: usize,
    lead: usize,
) -> bool {
    let part = |texel: &[f32; 3], c: usize| f64::from(texel[c]) / largest[c];
    entering(params, texels).iter().all(|texel| (part(texel, c) - part(texel, lead)).abs() <= 1e-6)
}

/// The texels of an object's entry texture; one white texel if it has none.
fn entering<'a>(params: &ObjectParams, texels: &'a [[f32; 3]]) -> &'a [[f32; 3]] {
    if params.texture_side & ENTRY == 0 {
        return &[[1.0; 3]];
    }
    let [first, width, height] =
        [params.texture_first, params.texture_size[0], params.texture_size[1]].map(|n| n as usize);
    texels.get(first..first + width * height).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::prepare::textures::*;

    #[test]
    fn whole_periods_are_taken_off() {
        let uvs = [[10.25, -3.5], [11.5, -3.0], [10.5, -4.25]];
        let CornerUvs { a, b, c } = near(&uvs, [Some(1.0); 2]);
        // From above: 4.5, 4.0 and 5.25; the least is 4.
        assert_eq!([a, b, c], [[0.25, 0.5], [1.5, 0.0], [0.5, 1.25]]);
        assert_eq!(near(&uvs, [Some(2.0); 2]).a, [0.25, 0.5]);
        let odd = uvs.map(|[u, v]| [u - 1.0, v]);
        assert_eq!(near(&odd, [Some(2.0); 2]).a, [1.25, 0.5]);
        assert_eq!(near(&uvs, [None; 2]).a, [10.25, 4.5]);
    }

    #[test]
    fn a_ratio_is_kept_only_where_all_that_enters_keeps_it() {
        let entry = |first: u32| ObjectParams {
            texture_side: ENTRY,
            texture_size: [2, 1],
            texture_first: first,
            ..ObjectParams::default()
        };
        let texels = [[0.5, 0.25, 0.5], [0.25, 0.125, 0.5], [0.75; 3], [0.1; 3]];
        let kept = |params: ObjectParams| {
            let largest = brightest_entry(&params, &texels);
            [(1, 0), (2, 0)].map(|(c, lead)| keeps_ratio(&params, &texels, largest, c, lead))
        };
        assert_eq!(kept(ObjectParams::default()), [true, true]);
        assert_eq!(kept(entry(0)), [true, false]);
        assert_eq!(kept(entry(2)), [true, true]);
    }
}
