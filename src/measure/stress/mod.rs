//! Extreme cases: scenes and form factors at the limits of the input, each with the program's behaviour, the bound on
//! its error against `f64`, and the reason for that bound.
//!
//! A case passes if every value is finite, none is negative, none is zero where there must be light, and the errors
//! are within the case's bounds, for the device's usual method and for brute force in `f32`.

mod diffusion;
pub mod factor;
mod factors;
mod materials;
mod meshes;
mod places;
mod shade;
mod solve;
mod walk;

use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::measure::norms::Norms;

/// Bound on an error; no unit. Below 1, or else an all-black result would pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Bound on the L2 error sqrt(sum A dB^2 / sum A B^2); for form factors, on the root mean square of the scaled
    /// errors.
    pub l2: f64,
    /// Bound on the largest error |dB| / rms(B); for form factors, on the scaled error |F - F_ref| / R_full.
    pub max: f64,
}

/// For results that must be exactly zero.
pub const ZERO: Bound = Bound { l2: 0.0, max: 0.0 };

/// A bound of about three times the largest error measured on the CPU, lavapipe and SwiftShader: the error that the
/// case's reason explains, with a margin for drivers that round differently.
const fn within(l2: f64, max: f64) -> Bound {
    Bound { l2, max }
}

/// The bound for most scenes, and its reason.
const USUAL: Bound = within(4e-4, 2.5e-3);
const USUAL_REASON: &str = "links to second order at the default tolerance of 1e-3: their errors cancel in part, to about \
                            1e-4; brute force takes one sample with its second moment up to chi = 0.1, much the same";
/// The same for sheets, where near and far faces contribute alike.
const SHEET: Bound = within(1e-3, 4e-3);
const SHEET_REASON: &str = "on a sheet distant faces count as much as near ones, so more links err, and together: up to the \
                            tolerance; \
                            brute force as elsewhere";

/// One extreme case.
pub struct Case {
    /// Its name, as `--only` takes it.
    pub name: &'static str,
    /// What the program does here, and how that differs from the ordinary case.
    pub fallback: &'static str,
    /// Bound for the device's usual method; for form factors, for the stage `evaluate`.
    pub bound: Bound,
    /// Bound for brute force in `f32` on the same device.
    pub brute: Bound,
    /// The reason for the bounds.
    pub reason: &'static str,
    /// What the case computes.
    kind: Kind,
}

/// What a case computes.
enum Kind {
    /// Form factors of single triangles at single points, by the edge form.
    Factors(fn() -> Vec<factor::Pair>),
    /// The radiosity of a scene.
    Scene(fn() -> Result<solve::Setup>),
    /// A picture by the CDRF: in closed form, and from the table in the place of brute force.
    Shade(fn() -> Result<crate::scene::Scene>),
    /// A random walk through a scene: against the CPU's, and its balance in the place of brute force.
    Walk(fn() -> Result<crate::scene::Scene>),
    /// Diffusion: against the CPU's, and what is left of the equation in the place of brute force.
    Diffusion(fn() -> Result<crate::scene::Scene>),
}

/// Errors of one method in one case, worst channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// See [`Bound::l2`].
    pub l2: f64,
    /// See [`Bound::max`].
    pub max: f64,
}

impl From<Norms> for Worst {
    fn from(norms: Norms) -> Self {
        Self { l2: norms.l2, max: norms.max }
    }
}

/// The result of a case.
pub struct Outcome {
    /// The case.
    pub case: &'static Case,
    /// Whether every checked value was finite and not negative.
    pub sound: bool,
    /// Errors of the usual method, or of the stage `evaluate`.
    pub usual: Worst,
    /// Errors of brute force in `f32`.
    pub brute: Worst,
    /// Errors of the irradiance octree in `f32`, for scenes; reported only, no effect on pass or fail.
    pub octree: Option<Worst>,
    /// Everything found wrong; empty if the case passes.
    pub faults: Vec<String>,
}

/// A deliberate change to the results, to prove that the checks can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plant {
    /// One value becomes NaN.
    NotANumber,
    /// One value becomes infinite.
    Infinite,
    /// One value becomes negative.
    Negative,
    /// All values become zero.
    Dark,
    /// All values grow by a tenth.
    TenthMore,
    /// All values grow by 1e-30.
    Trace,
}

impl Plant {
    /// Applies the change.
    fn apply(self, values: &mut [[f32; 3]]) {
        let every = |values: &mut [[f32; 3]], f: fn(f32) -> f32| values.iter_mut().flatten().for_each(|x| *x = f(*x));
        let one = |values: &mut [[f32; 3]], x: f32| values.iter_mut().skip(1).take(1).for_each(|value| value[1] = x);
        match self {
            Self::NotANumber => one(values, f32::NAN),
            Self::Infinite => one(values, f32::INFINITY),
            Self::Negative => one(values, -1e-30),
            Self::Dark => every(values, |_| 0.0),
            Self::TenthMore => every(values, |x| x * 1.1),
            Self::Trace => every(values, |x| x + 1e-30),
        }
    }
}

/// The results of one method in one case: its errors, and other faults.
#[derive(Default)]
struct Found {
    error: Worst,
    unsound: bool,
    faults: Vec<String>,
}

impl Found {
    /// Reports values that are NaN, infinite or negative.
    fn look(&mut self, what: &str, values: &[[f32; 3]]) {
        let bad = values.iter().flatten().filter(|x| !(x.is_finite() && **x >= 0.0)).count();
        if bad > 0 {
            self.unsound = true;
            self.faults.push(format!("{bad} values of {what} are not finite, or negative"));
        }
    }
}

/// All cases: single form factors, materials, meshes, positions and lights, shading by curvature, random walks,
/// diffusion.
fn cases() -> impl Iterator<Item = &'static Case> {
    factors::CASES
        .iter()
        .chain(materials::CASES)
        .chain(places::CASES)
        .chain(shade::CASES)
        .chain(walk::CASES)
        .chain(diffusion::CASES)
}

/// Runs the cases whose name contains `only`, on a device or, without one, on the CPU.
pub fn stress(device: Option<&Device>, only: &str, plant: Option<Plant>) -> Result<Vec<Outcome>> {
    let chosen: Vec<_> = cases().filter(|case| case.name.contains(only)).collect();
    if chosen.is_empty() {
        let names: Vec<_> = cases().map(|case| case.name).collect();
        return Err(Input::new("no case has this in its name").found(only).expected(names.join("; ")).into());
    }
    chosen.into_iter().map(|case| run(case, device, plant)).collect()
}

fn run(case: &'static Case, device: Option<&Device>, plant: Option<Plant>) -> Result<Outcome> {
    let (usual, brute, octree) = match case.kind {
        Kind::Factors(pairs) => {
            let [usual, brute] = factor::run(&pairs(), device, plant)?;
            (usual, brute, None)
        }
        Kind::Shade(make) => {
            let [usual, brute] = shade::run(&make()?, device, plant)?;
            (usual, brute, None)
        }
        Kind::Walk(make) => {
            let [usual, brute] = walk::run(&make()?, device, plant)?;
            (usual, brute, None)
        }
        Kind::Diffusion(make) => {
            let [usual, brute] = diffusion::run(&make()?, device, plant)?;
            (usual, brute, None)
        }
        Kind::Scene(make) => {
            let [usual, brute, octree] = solve::run(&make()?, device, plant)?;
            (usual, brute, Some(octree.error))
        }
    };
    let sound = !usual.unsound && !brute.unsound;
    let mut faults = Vec::new();
    for (method, found, bound) in [("the method", &usual, case.bound), ("brute force", &brute, case.brute)] {
        faults.extend(found.faults.iter().map(|fault| format!("{method}: {fault}")));
        for (norm, error, bound) in [("L2", found.error.l2, bound.l2), ("largest", found.error.max, bound.max)] {
            // NaN is beyond any bound.
            if error.is_nan() || error > bound {
                faults.push(format!("{method}: the {norm} error {error:.2e} is beyond {bound:e}: {}", case.reason));
            }
        }
    }
    Ok(Outcome { case, sound, usual: usual.error, brute: brute.error, octree, faults })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_says_what_it_does_and_darkness_fails_its_bound() {
        let mut names: Vec<_> = cases().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), cases().count(), "two cases have one name");
        for case in cases() {
            assert!(!case.fallback.is_empty() && !case.reason.is_empty(), "{}", case.name);
            for bound in [case.bound, case.brute] {
                assert!(bound.l2 < 1.0 && bound.max < 1.0 && bound.l2 <= bound.max, "{}", case.name);
            }
        }
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn what_is_planted_is_found() {
        let fails = |only: &str, plant| stress(None, only, plant).unwrap().iter().all(|o| !o.faults.is_empty());
        let passes = |only: &str| stress(None, only, None).unwrap().iter().all(|o| o.faults.is_empty());
        for only in ["inside a triangle", "one lit face", "walk: light in a cavity", "diffusion: no absorption"] {
            assert!(passes(only), "{only}");
            for plant in [Plant::NotANumber, Plant::Infinite, Plant::Negative, Plant::Dark, Plant::TenthMore] {
                assert!(fails(only, Some(plant)), "{only}: {plant:?}");
            }
        }
        // For a bound of zero the smallest trace of light is a fault.
        assert!(passes("no light at all") && fails("no light at all", Some(Plant::Trace)));
        assert!(stress(None, "no such case", None).is_err());
    }
}
