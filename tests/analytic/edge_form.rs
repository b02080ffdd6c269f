//! The edge form against an area integral, over the configurations that meshes produce.

use super::materials::channels;
use super::quadrature::Area;
use crate::population::seeded::{Seeded, percentile};
use glam::DVec3;
use milkglass::internals::dipole::form_factor::footprint::Footprint;
use milkglass::internals::dipole::form_factor::gauss::{SIX, legendre};
use milkglass::internals::dipole::form_factor::{Distance, edge, exact, vector_area};
use milkglass::internals::dipole::profile::Dipole;

/// Where the receiver's foot lies in the plane of the triangle.
#[derive(Clone, Copy)]
enum Place {
    Inside,
    Edge,
    Vertex,
    Outside,
    Far,
}

/// One triangle, point and medium.
struct Case {
    triangle: [DVec3; 3],
    x_o: DVec3,
    dipole: Dipole,
    sliver: bool,
}

impl Case {
    fn footprint(&self) -> Footprint {
        Footprint::new(&self.triangle, [0, 1, 2], self.x_o).unwrap()
    }

    /// `J` of both sources, by the area integral.
    fn truth(&self, area: &Area) -> [f64; 2] {
        let normal = vector_area(&self.triangle).normalize();
        let delta = (self.x_o - self.triangle[0]).dot(normal);
        let foot = self.x_o - delta * normal;
        let Dipole { sigma, .. } = self.dipole;
        self.dipole.depths().map(|z| area.integral(self.triangle, foot, delta.hypot(z), sigma))
    }
}

/// Every material, channel and place, in the plane and off it; slivers last.
fn population(seed: u64) -> Vec<Case> {
    let mut random = Seeded(seed);
    let mut cases = Vec::new();
    for sliver in [false, true] {
        for (_, unit, _) in channels() {
            for place in [Place::Inside, Place::Edge, Place::Vertex, Place::Outside, Place::Far] {
                for turn in 0..40 {
                    cases.push(case(&mut random, &unit, place, turn % 2 == 1, sliver));
                }
            }
        }
    }
    cases
}

fn case(random: &mut Seeded, unit: &Dipole, place: Place, above: bool, sliver: bool) -> Case {
    // A triangle of any orientation whose longest edge is 1; a sliver is flattened towards one side.
    let mut triangle;
    loop {
        triangle = [(); 3].map(|()| random.direction() * random.between(0.2, 1.0));
        let longest = (0..3).map(|k| triangle[k].distance(triangle[(k + 1) % 3])).fold(0.0, f64::max);
        if vector_area(&triangle).length() > 0.1 * longest * longest {
            triangle = triangle.map(|corner| corner / longest);
            break;
        }
    }
    if sliver {
        let thin = random.log_between(1e-3, 1e-1);
        triangle[2] = triangle[0].lerp(triangle[1], 0.4).lerp(triangle[2], thin);
    }
    // The receiver's foot in the plane, then an optional offset to either side.
    let [a, b, c] = triangle;
    let (u, v) = (random.between(0.05, 0.95), random.between(0.05, 0.95));
    let inside = a.lerp(b, u).lerp(c, v);
    let away = (inside - (a + b + c) / 3.0).normalize_or(b - a);
    let foot = match place {
        Place::Inside => inside,
        Place::Edge => a.lerp(b, u),
        Place::Vertex => c,
        Place::Outside => a.lerp(b, u) + (a.lerp(b, u) - c) * random.log_between(1e-2, 2.0),
        Place::Far => inside + away * random.log_between(2.0, 30.0),
    };
    let normal = vector_area(&triangle).normalize();
    let sign = if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 };
    let lift = if above { sign * random.log_between(1e-3, 3.0) } else { 0.0 };
    // Scale the medium's lengths so that sigma times the longest edge is `wanted`.
    let wanted = random.log_between(1e-3, 3e2);
    let scale = if unit.sigma > 0.0 { wanted / unit.sigma } else { wanted * unit.z_real };
    let dipole =
        Dipole { sigma: unit.sigma * scale, z_real: unit.z_real / scale, z_virtual: unit.z_virtual / scale, ..*unit };
    Case { triangle, x_o: foot + normal * lift, dipole, sliver }
}

/// Errors of one method over a population, per source: relative to the exact value, and scaled by the dipole's form
/// factor of the whole plane.
struct Errors {
    scaled: Vec<f64>,
    relative: Vec<f64>,
}

impl Errors {
    fn of(cases: &[&Case], truth: &[[f64; 2]], method: impl Fn(&Footprint, f64, f64) -> f64) -> Self {
        let mut errors = Self { scaled: Vec::new(), relative: Vec::new() };
        for (case, truth) in cases.iter().zip(truth) {
            let footprint = case.footprint();
            let heights = Distance::Radial.heights(footprint.delta, &case.dipole);
            for ((z, h), truth) in case.dipole.depths().into_iter().zip(heights).zip(truth) {
                let error = (method(&footprint, case.dipole.sigma, h) - truth).abs();
                let part = z * case.dipole.strength * error;
                errors.scaled.push(part / case.dipole.total());
                if *truth > 1e-280 {
                    errors.relative.push(error / truth);
                }
            }
        }
        errors
    }

    /// The scaled 95th percentile and maximum; prints the relative ones as well.
    fn report(mut self, name: &str) -> [f64; 2] {
        let scaled = [0.95, 1.0].map(|part| percentile(&mut self.scaled, part));
        let show = |values: &[f64]| values.iter().map(|v| format!("{v:.1e} ")).collect::<String>();
        let relative = [0.5, 0.95, 1.0].map(|part| percentile(&mut self.relative, part));
        let (a, b) = (show(&scaled), show(&relative));
        println!("{name:12} scaled p95, max: {a}; relative p50, p95, max: {b}");
        scaled
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn six_nodes_reach_the_published_accuracy() {
    let (area, twelve) = (Area::new(), legendre(12));
    let population = population(20_031);
    for sliver in [false, true] {
        let cases: Vec<_> = population.iter().filter(|case| case.sliver == sliver).collect();
        let truth: Vec<_> = cases.iter().map(|case| case.truth(&area)).collect();
        println!("slivers: {sliver}, {} cases", cases.len());
        let errors = |method: fn(&Footprint, f64, f64) -> f64| Errors::of(&cases, &truth, method);
        let exact = errors(exact::integral).report("exact");
        let w = errors(|f, sigma, h| edge::integral(f, sigma, h, &SIX)).report("w, 6 nodes");
        let psi = errors(|f, sigma, h| edge::integral_psi(f, sigma, h, &SIX)).report("psi, 6 nodes");
        let fine = Errors::of(&cases, &truth, |f, s, h| edge::integral(f, s, h, &twelve));
        let fine = fine.report("w, 12 nodes");
        assert!(exact[1] < 1e-11);
        if sliver {
            // Slivers lose a digit: the contributions of their edges nearly cancel.
            assert!(w[0] < 1e-5 && w[1] < 2e-3);
        } else {
            // The levels measured when the method was chosen; in w the worst case is rarer and larger. The percentile
            // lies on a steep flank, so it differs by a factor of two between seeds.
            assert!(psi[0] < 5e-7 && psi[1] < 1e-3);
            assert!(w[0] < 8e-7 && w[1] < 3e-3);
            assert!(fine[0] < 1e-10);
        }
    }
}
