//! Limits of shading by curvature: its error against the hierarchical dipole per triangle, by the object's thickness
//! below the triangle and by curvature.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Input, Result};
use crate::geometry::trace::trace;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::plot::{Axis, Panel, Series, hue};
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{Receivers, Scene};
use crate::session::run::Session;
use crate::shading::diffuse::{received, sigma_0};
use crate::shading::reflectance::cdrf;
use crate::shading::smooth_curvature::kappa;
use crate::state::{State, wide};

/// The error up to which a verdict calls the method valid.
pub const ASKED: f64 = 0.1;

/// One triangle in one channel.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The object.
    pub object: usize,
    /// The triangle's index in the scene's mesh.
    pub triangle: u32,
    /// The channel.
    pub channel: usize,
    /// The triangle's area, scene unit^2.
    pub area: f64,
    /// sigma_0 kappa, radian.
    pub sigma: f64,
    /// Thickness of the object straight below the triangle, in multiples of sigma_0; infinite if the ray hits nothing
    /// of it.
    pub thickness: f64,
    /// Radiosity by the dipole, W per scene unit^2.
    pub dipole: f64,
    /// Radiosity by the CDRF, W per scene unit^2.
    pub cdrf: f64,
    /// Radiosity by Lambert's cosine, W per scene unit^2.
    pub lambert: f64,
}

/// Error over some of the places, sqrt(sum A d^2 / sum A B^2), and their share of the area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// The error.
    pub error: f64,
    /// The share of the area.
    pub area: f64,
}

/// Radiosity by the dipole, the CDRF and Lambert's cosine at every triangle of translucent objects.
pub fn places(scene: &Scene, device: Option<&Device>) -> Result<Vec<Place>> {
    let mut scene = scene.clone();
    (scene.transport.receivers, scene.transport.subdivide) = (Receivers::Faces, 0);
    scene.transport.divided = true;
    scene.camera.size = [1, 1];
    // Textures are removed: only one of dipole and CDRF applies them where light enters.
    let clear = scene.objects.iter_mut().filter(|object| object.material.opaque.is_none());
    clear.for_each(|object| object.material.texture = None);
    let solve = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut dipole = Session::new(&scene, device, solve)?;
    dipole.frame(Change::EVERYTHING)?;
    dipole.fetch(&[BufferId::radiosity])?;
    let local = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
    let mut session = Session::new(&scene, None, local)?;
    session.frame(Change::EVERYTHING)?;
    if session.state().data.curvature.is_empty() && session.state().objects.iter().any(|object| !object.opaque) {
        return Err(Input::new("no light shines: there is nothing to compare").expected("a [[light]]").into());
    }

    let (state, units) = (session.state(), *session.units());
    let mut all = Vec::new();
    for (number, object) in state.objects.iter().enumerate().filter(|(_, object)| !object.opaque) {
        let radiosity = &dipole.state().data.radiosity[dipole.state().objects[number].first.receivers..];
        let brightness = dipole.units().light;
        let triangles: Vec<u32> = (0..object.count.faces).map(|k| session.triangle(object.first.faces + k)).collect();
        let triangles = &triangles;
        let own = (object.first.faces..object.first.faces + object.count.faces).into_par_iter().flat_map_iter(|face| {
            let [shade, plain, sigma, spread, thickness] = at(state, number, face);
            let carried = wide(radiosity[face - object.first.faces]) * brightness;
            let leaf = object.first.nodes + state.data.leaves[face] as usize;
            let area = f64::from(state.data.clusters[leaf].area) / units.length.powi(2);
            let triangle = triangles[face - object.first.faces];
            (0..3).map(move |channel| Place {
                object: number,
                triangle,
                channel,
                area,
                sigma: sigma[channel],
                thickness: thickness[channel] / spread[channel].max(f64::MIN_POSITIVE),
                dipole: carried[channel],
                cdrf: shade[channel] * units.light,
                lambert: plain[channel] * units.light,
            })
        });
        all.par_extend(own);
    }
    Ok(all)
}

/// Radiosity of a triangle at its centroid by the CDRF and by Lambert's cosine, its sigma and sigma_0, and the distance
/// straight through the object below it.
fn at(state: &State, number: usize, face: usize) -> [DVec3; 5] {
    let (data, params) = (&state.data, &state.data.object_params[number]);
    let corners = data.triangles[face].map(|v| v as usize);
    let mean = |value: &dyn Fn(usize) -> DVec3| corners.iter().map(|&v| value(v)).sum::<DVec3>() / 3.0;
    let point = mean(&|v| wide(data.in_scene()[v]));
    let normal = mean(&|v| wide(data.normals_in_scene()[v])).normalize_or_zero();
    let bend = corners.iter().map(|&v| f64::from(kappa(data, v))).sum::<f64>() / 3.0;
    let spread = sigma_0(data, params, face, [1.0 / 3.0; 3]);
    let sigma = spread * bend;
    let light = [sigma, DVec3::ZERO].map(|sigma| received(state, face, [point, normal], sigma, &cdrf));
    let [a, b, c] = corners.map(|v| wide(data.in_scene()[v]));
    let inward = -(b - a).cross(c - a).normalize_or_zero();
    // Start slightly below the surface to avoid hitting it.
    let start = point + 1e-5 * inward;
    let met = trace(data, start.to_array().map(|x| x as f32), inward.to_array().map(|x| x as f32));
    let through = f64::from(met.numerator) / f64::from(met.denominator);
    let object = &state.objects[number];
    let own = (object.first.faces..object.first.faces + object.count.faces).contains(&(met.face as usize));
    let thickness = if own { through } else { f64::INFINITY };
    [wide(params.diffuse) * light[0], wide(params.diffuse) * light[1], sigma, spread, DVec3::splat(thickness)]
}

/// The error of the CDRF over the places for which `selects` holds.
pub fn share(places: &[Place], selects: impl Fn(&Place) -> bool) -> Share {
    share_by(places, |place| place.cdrf, selects)
}

/// The error of Lambert's cosine over the places for which `selects` holds.
pub fn lambert_share(places: &[Place], selects: impl Fn(&Place) -> bool) -> Share {
    share_by(places, |place| place.lambert, selects)
}

fn share_by(places: &[Place], value: impl Fn(&Place) -> f64, selects: impl Fn(&Place) -> bool) -> Share {
    let sum = |f: &dyn Fn(&Place) -> f64| places.iter().filter(|place| selects(place)).map(f).sum::<f64>();
    let whole: f64 = places.iter().map(|place| place.area).sum();
    let squares = sum(&|p| p.area * (value(p) - p.dipole).powi(2));
    let light = sum(&|p| p.area * p.dipole.powi(2));
    let error = if light > 0.0 { (squares / light).sqrt() } else { 0.0 };
    Share { error, area: if whole > 0.0 { sum(&|p| p.area) / whole } else { 0.0 } }
}

/// Thickness limits for verdicts, in multiples of sigma_0.
pub const THICK: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Limits of sigma for verdicts.
pub const BENT: [f64; 4] = [0.1, 0.25, 0.5, 1.0];

/// One line of text: the minimum thickness and the maximum sigma for which the error is within [`ASKED`], chosen for
/// the largest share of the surface.
#[must_use]
pub fn verdict(places: &[Place]) -> String {
    let all = share(places, |_| true);
    let percent = |x: f64| format!("{:.0} %", 100.0 * x);
    if all.error <= ASKED {
        return format!("within {}: error {} over the whole surface", percent(ASKED), percent(all.error));
    }
    // Choices with fewer conditions come first; after `rev`, `max_by` prefers them among equal areas.
    let thicks = || [0.0].into_iter().chain(THICK);
    let bends = || [f64::INFINITY].into_iter().chain(BENT.into_iter().rev());
    let choices: Vec<_> = thicks().flat_map(|thick| bends().map(move |bent| (thick, bent))).collect();
    let inside = |thick: f64, bent: f64| move |p: &Place| p.thickness >= thick && p.sigma <= bent;
    let found = choices
        .into_iter()
        .rev()
        .map(|(thick, bent)| (thick, bent, share(places, inside(thick, bent))))
        .filter(|(.., part)| part.error <= ASKED && part.area >= 0.01)
        .max_by(|a, b| a.2.area.total_cmp(&b.2.area));
    let Some((thick, bent, part)) = found else {
        return format!(
            "not within {} on any part selected by thickness or curvature: error {}",
            percent(ASKED),
            percent(all.error)
        );
    };
    let rest = share(places, |p| !inside(thick, bent)(p));
    let mut words = Vec::new();
    if thick > 0.0 {
        words.push(format!("at least {thick} sigma_0 thick"));
    }
    if bent.is_finite() {
        words.push(format!("sigma_0 kappa is at most {bent}"));
    }
    format!(
        "within {} where {} ({} of the surface, error {}); elsewhere {}",
        percent(ASKED),
        words.join(" and "),
        percent(part.area),
        percent(part.error),
        percent(rest.error)
    )
}

/// A part of a range, in words.
#[must_use]
pub fn span(ends: &[f64]) -> String {
    if ends[1].is_infinite() { format!("from {}", ends[0]) } else { format!("{} to {}", ends[0], ends[1]) }
}

/// The parts between these limits, from 0 to infinity.
#[must_use]
pub fn parts(limits: &[f64]) -> Vec<[f64; 2]> {
    let edges = [&[0.0], limits, &[f64::INFINITY]].concat();
    edges.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Most dots of the plot.
const DOTS: usize = 4000;

/// Draws error against thickness, a dot per triangle and channel, from blue to red by sigma.
pub fn svg(name: &str, all: &[Place]) -> Result<String> {
    let every = all.len().div_ceil(DOTS).max(1);
    let some: Vec<&Place> = all.iter().step_by(every).filter(|p| p.dipole > 0.0).collect();
    let class = |(k, [low, high]): (usize, [f64; 2])| {
        let own = some.iter().filter(|p| p.sigma >= low && p.sigma < high);
        let error = |p: &Place| 100.0 * ((p.cdrf - p.dipole) / p.dipole).clamp(-1.0, 2.0);
        let dots = own.map(|p| (p.thickness.clamp(0.1, 100.0), error(p)));
        Series::dots(format!("sigma {}", span(&[low, high])), dots).colored(hue(k as f64 / BENT.len() as f64))
    };
    let axes = [Axis::log("thickness / sigma_0"), Axis::linear("error, % of the dipole's")];
    let classes = parts(&BENT).into_iter().enumerate().map(class).collect::<Vec<_>>();
    Panel::new(format!("{name}: error of the CDRF by thickness"), axes, classes).svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(thickness: f64, sigma: f64, cdrf: f64) -> Place {
        Place { object: 0, triangle: 0, channel: 0, area: 2.0, sigma, thickness, dipole: 1.0, cdrf, lambert: 0.7 }
    }

    #[test]
    fn a_verdict_parts_what_is_thin() {
        let good = vec![place(5.0, 0.3, 1.05), place(0.5, 0.3, 0.95)];
        assert_eq!(verdict(&good), "within 10 %: error 5 % over the whole surface");
        let thin = vec![place(5.0, 0.3, 1.05), place(9.0, 2.0, 0.95), place(1.5, 0.3, 2.0)];
        assert_eq!(
            verdict(&thin),
            "within 10 % where at least 2 sigma_0 thick (67 % of the surface, error 5 %); elsewhere 100 %"
        );
        let bad = vec![place(5.0, 0.3, 2.0)];
        assert!(verdict(&bad).starts_with("not within 10 %"));
        let plain = lambert_share(&thin, |_| true);
        assert!((plain.error - 0.3).abs() < 1e-12 && plain.area == 1.0);
        assert_eq!(share(&thin, |p| p.sigma > 1.0), Share { error: 0.050_000_000_000_000_044, area: 1.0 / 3.0 });
    }
}
