//! Stage `pack_normals`: normal and kappa of each vertex in 8 bytes. Shading per pixel is bound by memory loads.
//!
//! The components of the normal are rounded to 1 / 32767, which turns it by less than 3e-5 radian. kappa + 2^-17 is
//! stored with a float's exponent and 11 bits of fraction; the offset keeps 0 exact and the exponent in range. The
//! error of kappa is below 2^-12 (kappa + 2^-17). A relative change of sigma changes f by at most 0.45 times as much,
//! so f changes by less than 1.2e-4 wherever kappa is above 1e-4 in internal units.

use glam::DVec3;
use rayon::prelude::*;

use super::curvature_sums::rough;
use super::smooth_curvature::kappa as kappa_of;
use crate::error::Result;
use crate::layout::{BufferId, KAPPA_LEAST};
use crate::state::{Carrier, Granularity, Local, Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "pack_normals",
    about: "normal and kappa of each vertex in 8 bytes",
    equation: "floor(32767 n + 1/2); kappa + 2^-17 as a float with 11 bits of fraction",
    writes: &[(BufferId::packed_normals, Role::Output, Tolerance::Exact)],
    reason: "multiplications, additions and floors, each rounded once",
    granularity: Granularity::Object,
    carriers: &[Carrier::Cdrf, Carrier::Lambert],
    runs: |update| update.material() || update.placed(),
    ..super::stage(cpu, gpu)
};

/// Packs a normal, each component from -1 to 1, and a kappa of at least 0.
#[must_use]
pub fn pack(normal: [f32; 3], kappa: f32) -> [u32; 2] {
    let [x, y, z] = normal.map(|n| (n * 32767.0 + 0.5).floor() as i32 as u32 & 0xffff);
    let code = ((kappa + KAPPA_LEAST).to_bits() - KAPPA_LEAST.to_bits() + 0x800) >> 12;
    [x | y << 16, z | code.min(0xffff) << 16]
}

/// The normal, not normalised, and kappa.
#[must_use]
pub fn unpack([low, high]: [u32; 2]) -> (DVec3, f64) {
    let [x, y, z] = [low, low >> 16, high].map(|word| f64::from(word as u16 as i16));
    let kappa = f32::from_bits((high >> 16 << 12) + KAPPA_LEAST.to_bits());
    (DVec3::new(x, y, z) / 32767.0, f64::from(kappa) - f64::from(KAPPA_LEAST))
}

/// Which kappa the shading method uses: 0 for none, 1 for that of stage `curvature`, 2 for the smoothed one.
fn bent(state: &State) -> u32 {
    match state.method.local {
        Some(Local::Lambert) => 0,
        _ if rough(state).is_some() => 1,
        _ => 2,
    }
}

fn cpu(state: &mut State, _at: Scope) {
    let (data, bent) = (&state.data, bent(state));
    let kappa = |v: usize| if bent > 0 { kappa_of(data, v) } else { 0.0 };
    state.data.packed_normals =
        data.normals_in_scene().par_iter().enumerate().map(|(v, &normal)| pack(normal, kappa(v))).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[bent(pass.state)], &[], pass.object().count.vertices)
}

#[cfg(test)]
mod tests {
    use crate::shading::pack_normals::*;
    use crate::shading::reflectance::cdrf;
    use crate::state::wide;

    #[test]
    fn little_is_lost() {
        let share = |k: u32, rate: f64| (f64::from(k) * rate).fract();
        let (mut turned, mut lost, mut moved) = (0f64, 0f64, 0f64);
        for k in 1..100_000 {
            let direction = DVec3::new(share(k, 0.754_877), share(k, 0.569_84), share(k, 0.324_718)) - 0.5;
            let normal = direction.normalize().as_vec3().to_array();
            // Over nine orders of magnitude.
            let kappa = 10f64.powf(9.0 * share(k, 0.618_034) - 5.0) as f32;
            let (found, bend) = unpack(pack(normal, kappa));
            turned = turned.max(found.angle_between(wide(normal)));
            lost = lost.max((bend - f64::from(kappa)).abs() / (f64::from(kappa) + f64::from(KAPPA_LEAST)));
            // sigma from 0 to 4; sigma_0 follows.
            let sigma = 4.0 * share(k, 0.445_042);
            let cosine = 2.0 * share(k, 0.801_938) - 1.0;
            if kappa > 1e-4 {
                moved = moved.max((cdrf(cosine, sigma * bend / f64::from(kappa)) - cdrf(cosine, sigma)).abs());
            }
        }
        assert!(turned < 3e-5 && turned > 1e-5, "{turned}");
        assert!(lost < 2.5e-4 && lost > 2e-4, "{lost}");
        assert!(moved < 1.2e-4 && moved > 3e-5, "{moved}");
    }

    #[test]
    fn its_ends_are_kept() {
        assert_eq!(unpack(pack([0.0; 3], 0.0)), (DVec3::ZERO, 0.0));
        assert_eq!(unpack(pack([1.0, -1.0, 0.0], 0.0)).0, DVec3::new(1.0, -1.0, 0.0));
        // The largest curvature that stage `curvature` can give, and a value beyond any curvature.
        assert!((unpack(pack([0.0; 3], 1.74e4)).1 / 1.74e4 - 1.0).abs() < 2.5e-4);
        assert!(unpack(pack([0.0; 3], f32::MAX)).1 > 3e4);
    }
}
