//! Stage `deform`: moves an object's vertices from their positions at rest: twists, bends, bumps, noise and morphs.
//!
//! All of it, sine and cosine included, is `f32` additions, multiplications and comparisons in the order of
//! `glsl/geometry/deform.comp`, so that every device computes the same shape to the last bit and makes the same
//! decisions on it. Normals are those at rest, whatever deformations come before: bumps and noise belong before
//! twists and bends.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{
    BufferId, Buffers, DEFORM_BEND, DEFORM_BUMP_AXIS, DEFORM_BUMP_NORMAL, DEFORM_MORPH, DEFORM_SKIN, DEFORM_TWIST,
    Deform, SINE,
};
use crate::state::{Pass, Role, Scope, Serves, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "deform",
    about: "vertices that are twisted, bent, raised by bumps and noise, or morphed",
    equation: "twist: turned by rate h about the axis; bend: arc of radius 1 / rate; bump: height (1 - r^2 / R^2)^2; Perlin 2002; morph: weight times the way to the other mesh's vertex",
    writes: &[(BufferId::positions, Role::Update, Tolerance::Exact)],
    reason: "additions, multiplications and comparisons in f32, sine and cosine by a polynomial",
    serves: Serves { object: |object, _| object.deforms > 0, none: "nothing deforms an object" },
    ..super::stage(cpu, gpu)
};

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn each(f: impl Fn(usize) -> f32) -> [f32; 3] {
    [f(0), f(1), f(2)]
}

/// Sine of an angle in turns, of at most a quarter turn.
fn quarter(x: f32) -> f32 {
    let z = x * x;
    let mut sum = SINE[6];
    for k in (0..6).rev() {
        sum = sum * z + SINE[k];
    }
    sum * x
}

/// Sine and cosine of an angle in turns, in step with `glsl/geometry/turn.glsl`.
pub fn turn(turns: f32) -> [f32; 2] {
    let x = turns - (turns + 0.5).floor();
    let half = if x < 0.0 { -0.5 - x } else { 0.5 - x };
    [quarter(if x.abs() > 0.25 { half } else { x }), quarter(0.25 - x.abs())]
}

/// Gradient noise, -1 to 1: Perlin 2002, with a hash in place of the table.
fn noise(p: [f32; 3]) -> f32 {
    let cell = p.map(f32::floor);
    let f = each(|k| p[k] - cell[k]);
    let fade = f.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let at = |k: u32| {
        let step = [k & 1, (k >> 1) & 1, k >> 2];
        let [x, y, z]: [u32; 3] = std::array::from_fn(|k| (cell[k] as i32 as u32).wrapping_add(step[k]));
        let mut h = x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
        h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
        h ^= h >> 15;
        let [a, b, c] = each(|k| f[k] - step[k] as f32);
        let u = if h & 8 == 0 { a } else { b };
        let v = if h & 12 == 0 {
            b
        } else if h & 13 == 12 {
            a
        } else {
            c
        };
        (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
    };
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let along = |k: u32| mix(at(k), at(k + 1), fade[0]);
    let across = |k: u32| mix(along(k), along(k + 2), fade[1]);
    mix(across(0), across(4), fade[2])
}

/// Where a deformation moves a point that has this normal at rest; a morph moves it by its weight times `way`, a skin
/// to `way`.
pub fn displace(deform: &Deform, p: [f32; 3], normal: [f32; 3], way: [f32; 3]) -> [f32; 3] {
    let d = deform;
    let from = each(|k| p[k] - d.origin[k]);
    match d.kind {
        DEFORM_TWIST => {
            let height = dot(from, d.axis);
            let [s, c] = turn(d.rate * (height - d.low).clamp(0.0, d.extent));
            let a = d.axis;
            let q = each(|k| from[k] - height * a[k]);
            let side = [a[1] * q[2] - a[2] * q[1], a[2] * q[0] - a[0] * q[2], a[0] * q[1] - a[1] * q[0]];
            each(|k| d.origin[k] + (height * a[k] + (c * q[k] + s * side[k])))
        }
        DEFORM_BEND => {
            let (height, lean) = (dot(from, d.axis), dot(from, d.toward));
            let above = height - d.low;
            let inside = above.clamp(0.0, d.extent);
            let beyond = above - inside;
            let [s, c] = turn(d.rate * inside);
            // The ways up the arc and away from the axis; at small curvature by series, because the large radius would
            // cancel.
            let phi = 6.283_185_5 * (d.rate * inside);
            let z = phi * phi;
            let flat = z < 0.0625;
            let rise = if flat { inside * (1.0 - z * (0.166_666_67 - z * 0.008_333_334)) } else { d.amount * s };
            let part = 0.5 - z * (0.041_666_668 - z * 0.001_388_888_9);
            let drift = if flat { inside * (phi * part) } else { d.amount * (1.0 - c) };
            let up = d.low + rise - lean * s + beyond * c - height;
            let out = drift + lean * c + beyond * s - lean;
            each(|k| p[k] + (up * d.axis[k] + out * d.toward[k]))
        }
        DEFORM_BUMP_AXIS | DEFORM_BUMP_NORMAL => {
            let share = 1.0 - dot(from, from) * d.rate;
            let height = if share > 0.0 { d.amount * (share * share) } else { 0.0 };
            let along = if d.kind == DEFORM_BUMP_AXIS { d.axis } else { normal };
            each(|k| p[k] + height * along[k])
        }
        DEFORM_MORPH => each(|k| p[k] + d.amount * way[k]),
        DEFORM_SKIN => way,
        _ => {
            let height = d.amount * noise(from.map(|x| x * d.rate));
            each(|k| p[k] + height * normal[k])
        }
    }
}

/// The displacement of a vertex to its position in a morph's other mesh, or its place by a skin (`skinned` begins with
/// the object's first vertex); 0 for any other deformation.
pub fn way(morphs: &[[f32; 3]], skinned: &[[f32; 3]], deform: &Deform, vertex: usize) -> [f32; 3] {
    match deform.kind {
        DEFORM_MORPH => morphs[deform.first as usize + vertex],
        DEFORM_SKIN => skinned[vertex],
        _ => [0.0; 3],
    }
}

fn cpu(state: &mut State, _at: Scope) {
    deform(&mut state.data, 0);
}

/// Deforms the vertices of one object.
pub fn deform(data: &mut Buffers, object: usize) {
    let params = data.object_params[object];
    let deforms = &data.deforms[params.first_deform as usize..(params.first_deform + params.deforms) as usize];
    // In a state of one object `rest` begins at 0, in one of several objects at the object's first vertex.
    let (first, count) = (params.first_vertex as usize, params.vertices as usize);
    let begin = if data.object_params.len() == 1 { 0 } else { first };
    let (rest, normals) = (&data.rest[begin..], &data.rest_normals[begin..]);
    let skinned = data.skinned.get(begin..).unwrap_or_default();
    data.positions[first..first + count].par_iter_mut().enumerate().for_each(|(vertex, place)| {
        let way = |deform| way(&data.morphs, skinned, deform, vertex);
        *place = deforms.iter().fold(rest[vertex], |p, deform| displace(deform, p, normals[vertex], way(deform)));
    });
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.vertices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::DEFORM_NOISE;
    use glam::DVec3;
    use std::f64::consts::TAU;

    #[test]
    fn sines() {
        for k in -4000..4000 {
            let turns = k as f32 * 1.234_5e-3;
            let [s, c] = turn(turns).map(f64::from);
            let angle = TAU * f64::from(turns);
            assert!((s - angle.sin()).abs() < 4e-7 * (1.0 + f64::from(turns).abs()), "{turns}: {s}");
            assert!((c - angle.cos()).abs() < 4e-7 * (1.0 + f64::from(turns).abs()), "{turns}: {c}");
        }
    }

    fn wide(p: [f32; 3]) -> DVec3 {
        DVec3::from_array(p.map(f64::from))
    }

    fn places() -> impl Iterator<Item = [f32; 3]> {
        (0..400u32).map(|i| each(|k| ((i * 37 + 11).wrapping_mul(k as u32 * 2 + 7919) % 1000) as f32 / 1000.0 - 0.5))
    }

    #[test]
    fn twists_and_bends_are_those_of_double_precision() {
        let axis = [0.6, 0.0, 0.8];
        let (a, t) = (wide(axis), DVec3::Y);
        for rate in [0.9, -0.3, 0.02, 1e-5] {
            let (low, length) = (-0.3f32, 0.5f32);
            let span = Deform {
                origin: [0.1, 0.05, -0.02],
                axis,
                toward: [0.0, 1.0, 0.0],
                low,
                extent: length,
                rate,
                ..Deform::default()
            };
            let twist = Deform { kind: DEFORM_TWIST, ..span };
            let bend = Deform { kind: DEFORM_BEND, amount: 1.0 / (TAU as f32 * rate), ..span };
            for p in places() {
                let from = wide(p) - wide(span.origin);
                let height = from.dot(a);
                let inside = (height - f64::from(low)).clamp(0.0, f64::from(length));
                let angle = TAU * f64::from(rate) * inside;
                let turned = glam::DQuat::from_axis_angle(a, angle) * from + wide(span.origin);
                assert!(wide(displace(&twist, p, [0.0; 3], [0.0; 3])).distance(turned) < 1e-6, "{rate}: {p:?}");
                // Along the arc, then by the lean, all turned from the axis towards `toward`.
                let (beyond, lean) = (height - f64::from(low) - inside, from.dot(t));
                let radius = f64::from(length) / (TAU * f64::from(rate) * f64::from(length));
                let arc = radius * (angle.sin() * a + (1.0 - angle.cos()) * t);
                let (up, out) = (angle.cos() * a + angle.sin() * t, angle.cos() * t - angle.sin() * a);
                let side = from - height * a - lean * t;
                let bent = wide(span.origin) + f64::from(low) * a + arc + beyond * up + lean * out + side;
                assert!(wide(displace(&bend, p, [0.0; 3], [0.0; 3])).distance(bent) < 2e-6, "{rate}: {p:?}");
            }
        }
    }

    #[test]
    fn bumps_and_noise_are_smooth_and_bounded() {
        let normal = [0.0, 0.0, 1.0];
        let bump = Deform { kind: DEFORM_BUMP_NORMAL, rate: 16.0, amount: 0.2, ..Deform::default() };
        assert_eq!(displace(&bump, [0.0; 3], normal, [0.0; 3]), [0.0, 0.0, 0.2]);
        assert_eq!(displace(&bump, [0.25, 0.0, 0.0], normal, [0.0; 3]), [0.25, 0.0, 0.0]);
        let side = Deform { kind: DEFORM_BUMP_AXIS, axis: [1.0, 0.0, 0.0], ..bump };
        assert_eq!(displace(&side, [0.0; 3], normal, [0.0; 3]), [0.2, 0.0, 0.0]);
        let waves = Deform { kind: DEFORM_NOISE, rate: 6.0, amount: 0.1, ..Deform::default() };
        let (mut least, mut most) = (0.0f32, 0.0f32);
        for p in places() {
            let height = displace(&waves, p, normal, [0.0; 3])[2] - p[2];
            let near = displace(&waves, [p[0] + 1e-4, p[1], p[2]], normal, [0.0; 3])[2] - p[2];
            assert!(height.abs() <= 0.1001 && (near - height).abs() < 3e-4, "{p:?}: {height}, {near}");
            (least, most) = (least.min(height), most.max(height));
        }
        assert!(least < -0.05 && most > 0.05, "{least} to {most}");
        // At the lattice points noise is 0.
        assert_eq!(displace(&waves, [0.5, 0.5, -0.5], normal, [0.0; 3]), [0.5, 0.5, -0.5]);
    }

    #[test]
    fn morphs_go_a_share_of_the_way() {
        let half = Deform { kind: DEFORM_MORPH, first: 1, amount: 0.5, ..Deform::default() };
        let ways = [[9.0; 3], [1.0, -2.0, 4.0], [8.0, 0.0, 0.0]];
        assert_eq!([0, 1].map(|vertex| way(&ways, &[], &half, vertex)), [ways[1], ways[2]]);
        assert_eq!(displace(&half, [1.0, 1.0, 1.0], [0.0; 3], ways[1]), [1.5, 0.0, 3.0]);
        assert_eq!(way(&[], &[], &Deform { kind: DEFORM_NOISE, first: 7, ..half }, 3), [0.0; 3]);
    }
}
