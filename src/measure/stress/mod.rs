//! Extreme cases: scenes and form factors at the limits of the input, each with the program's behaviour, the bound on
//! its error against `f64`, and the reason for that bound. They are in `cases.toml`.
//!
//! A case passes if every value is finite, none is negative, none is zero where there must be light, and the errors
//! are within the case's bounds, for the device's usual method and for brute force in `f32`.

mod diffusion;
pub mod factor;
mod meshes;
mod setup;
mod shade;
mod solve;
mod walk;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use serde::{Deserialize, Deserializer};

use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::measure::norms::Norms;

/// Bound on an error; no unit. Below 1, or else an all-black result would pass.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
pub struct Bound {
    /// Bound on the L2 error sqrt(sum A dB^2 / sum A B^2); for form factors, on the root mean square of the scaled
    /// errors.
    pub l2: f64,
    /// Bound on the largest error |dB| / rms(B); for form factors, on the scaled error |F - F_ref| / R_full.
    pub max: f64,
}

/// One extreme case.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name, as `--only` takes it.
    #[serde(deserialize_with = "leaked")]
    pub name: Text,
    /// What the program does here, and how that differs from the ordinary case.
    #[serde(deserialize_with = "leaked")]
    pub fallback: Text,
    /// Bound for the device's usual method; for form factors, for the stage `evaluate`.
    pub bound: Bound,
    /// Bound for brute force in `f32` on the same device, or for what stands in its place.
    pub brute: Bound,
    /// The reason for the bounds.
    #[serde(deserialize_with = "leaked")]
    pub reason: Text,
    /// What the case computes.
    compute: Compute,
}

/// A text of the file of cases, which is read once.
type Text = &'static str;

fn leaked<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Text, D::Error> {
    String::deserialize(from).map(|text| &*text.leak())
}

/// What a case computes.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Compute {
    /// Form factors of single triangles at single points, by the edge form.
    Factors(factor::Combinations),
    /// The radiosity of a scene.
    Radiosity(setup::Setup),
    /// A picture by the CDRF: in closed form, and from the table in the place of brute force.
    Shading(setup::Setup),
    /// A random walk through a scene: against the CPU's, and its balance in the place of brute force.
    Walk(setup::Setup),
    /// Diffusion: against the CPU's, and the equation's residual in the place of brute force.
    Diffusion(setup::Setup),
}

/// The file of cases.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// The keys that the cases of a class share, by its name.
    class: BTreeMap<String, toml::Table>,
    /// The triangles, points and media of form factors.
    lists: factor::Lists,
    /// The cases.
    case: Vec<toml::Table>,
}

/// All cases: single form factors, materials, positions and meshes, light, shading by curvature, random walks,
/// diffusion. Also the lists of triangles, points and media of form factors.
static CASES: LazyLock<std::result::Result<(Vec<Case>, factor::Lists), String>> = LazyLock::new(|| {
    let File { class, lists, case } = toml::from_str(include_str!("cases.toml")).map_err(|e| e.to_string())?;
    let complete = |mut case: toml::Table| {
        let class = case.remove("class").and_then(|name| class.get(name.as_str()?)).ok_or("a case of no class")?;
        for (key, value) in class {
            case.entry(key.clone()).or_insert_with(|| value.clone());
        }
        case.try_into().map_err(|error| error.to_string())
    };
    Ok((case.into_iter().map(complete).collect::<std::result::Result<_, String>>()?, lists))
});

/// The cases, and the lists of triangles, points and media of form factors.
fn cases() -> Result<&'static (Vec<Case>, factor::Lists)> {
    CASES.as_ref().map_err(|error| Input::new(error).file(Path::new("cases.toml")).into())
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

impl Worst {
    /// The errors of values against the expected ones, all of the same weight; the largest is relative to the root mean
    /// square of `count` values.
    fn of(pairs: impl Iterator<Item = (f32, f32)>, count: usize) -> Self {
        let (mut whole, mut apart, mut most) = (0.0, 0.0, 0f64);
        for (expected, value) in pairs.map(|(expected, value)| (f64::from(expected), f64::from(value))) {
            whole += expected * expected;
            apart += (expected - value).powi(2);
            most = most.max((expected - value).abs());
        }
        Self { l2: (apart / whole).sqrt(), max: most / (whole / count.max(1) as f64).sqrt() }
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
    /// Errors of brute force in `f32`, or of what stands in its place.
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
        let second = |values: &mut [[f32; 3]], x: f32| values.iter_mut().skip(1).take(1).for_each(|value| value[1] = x);
        match self {
            Self::NotANumber => second(values, f32::NAN),
            Self::Infinite => second(values, f32::INFINITY),
            Self::Negative => second(values, -1e-30),
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

/// Runs the cases whose name contains `only`, on a device or, without one, on the CPU.
pub fn stress(device: Option<&Device>, only: &str, plant: Option<Plant>) -> Result<Vec<Outcome>> {
    let (cases, lists) = cases()?;
    let chosen: Vec<_> = cases.iter().filter(|case| case.name.contains(only)).collect();
    if chosen.is_empty() {
        let names: Vec<_> = cases.iter().map(|case| case.name).collect();
        return Err(Input::new("no case has this in its name").found(only).expected(names.join("; ")).into());
    }
    chosen.into_iter().map(|case| run(case, lists, device, plant)).collect()
}

fn run(case: &'static Case, lists: &factor::Lists, device: Option<&Device>, plant: Option<Plant>) -> Result<Outcome> {
    let mut octree = None;
    let [usual, brute] = match &case.compute {
        Compute::Factors(combinations) => factor::run(&combinations.pairs(lists)?, device, plant)?,
        Compute::Shading(setup) => shade::run(&setup.scene(&[])?, device, plant)?,
        Compute::Walk(setup) => walk::run(setup, device, plant)?,
        Compute::Diffusion(setup) => diffusion::run(&setup.scene(&[])?, device, plant)?,
        Compute::Radiosity(setup) => {
            let [usual, brute, by_octree] = solve::run(setup, device, plant)?;
            octree = Some(by_octree.error);
            [usual, brute]
        }
    };
    let sound = !usual.unsound && !brute.unsound;
    let second = match &case.compute {
        Compute::Factors(_) | Compute::Radiosity(_) => "brute force",
        Compute::Shading(_) => "the table",
        Compute::Walk(_) => "the balance of light",
        Compute::Diffusion(_) => "the equation",
    };
    let mut faults = Vec::new();
    for (method, found, bound) in [("the method", &usual, case.bound), (second, &brute, case.brute)] {
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
        let (cases, lists) = cases().unwrap();
        for (k, case) in cases.iter().enumerate() {
            assert!(cases[..k].iter().all(|other| other.name != case.name), "two cases are called {}", case.name);
            assert!(!case.fallback.is_empty() && !case.reason.is_empty(), "{}", case.name);
            for bound in [case.bound, case.brute] {
                assert!(bound.l2 < 1.0 && bound.max < 1.0 && bound.l2 <= bound.max, "{}", case.name);
            }
            if let Compute::Factors(combinations) = &case.compute {
                assert!(!combinations.pairs(lists).unwrap().is_empty(), "{}", case.name);
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
