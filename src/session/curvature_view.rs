//! A picture of a scene's curvature, as in figure 10a of Kubo et al. 2010: hot colours where the surface is strongly
//! curved.

use glam::DVec3;
use rayon::prelude::*;

use super::run::Session;
use crate::error::{Input, Result};
use crate::layout::{BufferId, Hit, OPAQUE_NOT};
use crate::scene::Kappa;
use crate::shading::fit;
use crate::shading::smooth_curvature::kappa;
use crate::state::{State, narrow, wide};
use crate::view::picture::Picture;

/// Colours from the least curvature to the largest, linear.
const RAMP: [DVec3; 5] = [
    DVec3::new(0.02, 0.05, 0.55),
    DVec3::new(0.02, 0.45, 0.6),
    DVec3::new(0.15, 0.6, 0.1),
    DVec3::new(0.85, 0.6, 0.03),
    DVec3::new(0.85, 0.06, 0.02),
];

/// Statistics of kappa over the vertices of all translucent objects.
#[derive(Clone, Debug, Default)]
pub struct CurvatureView {
    /// kappa at the ends of the colour ramp, 1 / scene unit: its 5th and 95th percentile.
    pub ends: [f64; 2],
    /// Difference between the cubic fit's kappa and stage `curvature`'s, neither smoothed, relative to their sum:
    /// median and 95th percentile; 0 where no vertex can be fitted.
    pub apart: [f64; 2],
}

impl CurvatureView {
    /// The colour of kappa, 1 / scene unit, on a logarithmic scale.
    #[must_use]
    pub fn color(&self, kappa: f64) -> [f32; 3] {
        let [low, high] = self.ends.map(|end| end.max(f64::MIN_POSITIVE).ln());
        let t = if high > low { (kappa.max(f64::MIN_POSITIVE).ln() - low) / (high - low) } else { 0.5 };
        let at = t.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
        let k = (at as usize).min(RAMP.len() - 2);
        narrow(RAMP[k].lerp(RAMP[k + 1], at - k as f64))
    }
}

/// The quantile at `share` of sorted values; 0 without values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted.get(((sorted.len() as f64 - 1.0).max(0.0) * share).round() as usize).copied().unwrap_or(0.0)
}

/// The share of the vertices of translucent objects where sigma is above 1 in every channel: there f hardly depends
/// on the light.
pub fn flat(session: &mut Session) -> Result<f64> {
    session.fetch(&[BufferId::curvature, BufferId::smooth_kappa])?;
    let data = &session.state().data;
    let objects = session.state().objects.iter().zip(&data.object_params).filter(|(object, _)| !object.opaque);
    let sigmas = objects.flat_map(|(object, params)| {
        let least = params.sigma_0.into_iter().fold(f32::INFINITY, f32::min);
        let first = params.first_vertex as usize;
        (first..first + object.count.vertices).map(move |vertex| least * kappa(data, vertex))
    });
    let (flat, all) =
        sigmas.fold((0.0, 0.0), |(flat, all), sigma| (flat + f64::from(u8::from(sigma > 1.0)), all + 1.0));
    Ok(if all > 0.0 { flat / all } else { 0.0 })
}

/// The curvature picture of a session that shades by curvature, after its frame, and the meaning of the colours.
pub fn curvature_view(session: &mut Session) -> Result<(Picture, CurvatureView)> {
    session.fetch(&[
        BufferId::hits,
        BufferId::normals,
        BufferId::placed_normals,
        BufferId::curvature,
        BufferId::smooth_kappa,
        BufferId::positions,
        BufferId::placed_positions,
    ])?;
    let (state, length) = (session.state(), session.units().length);
    let mean = session.scene().transport.curvature == Kappa::Mean;
    if state.data.curvature.is_empty() && state.objects.iter().any(|object| !object.opaque) {
        let fault = Input::new("no light shines: no curvature is computed").key("--view curvature");
        return Err(fault.expected("a [[light]]").into());
    }

    // kappa at all vertices, and how far the cubic fit differs.
    let (mut all, mut apart) = (Vec::new(), Vec::new());
    for (number, object) in state.objects.iter().enumerate().filter(|(_, object)| !object.opaque) {
        let alone = state.alone(number);
        all.extend((0..object.count.vertices).map(|vertex| f64::from(kappa(&alone.data, vertex)) * length));
        let difference = |vertex: usize| {
            let [k1, k2] = fit::at(&alone.data, vertex).filter(|_| alone.data.curvature[vertex].area > 0.0)?;
            let computed = f64::from(alone.data.curvature[vertex].kappa);
            let fitted = if mean { 0.5 * (k1 + k2).abs() } else { (0.5 * (k1 * k1 + k2 * k2)).sqrt() };
            Some((fitted - computed).abs() / (fitted + computed).max(f64::MIN_POSITIVE))
        };
        apart.par_extend((0..object.count.vertices).into_par_iter().filter_map(difference));
    }
    all.sort_by(f64::total_cmp);
    apart.sort_by(f64::total_cmp);
    let curvature_view = CurvatureView {
        ends: [0.05, 0.95].map(|share| quantile(&all, share)),
        apart: [0.5, 0.95].map(|share| quantile(&apart, share)),
    };

    // Opaque objects are grey.
    let paint = |hit: &Hit, corners: [(u32, f64); 3]| {
        if state.data.object_params[state.object_of(hit.face as usize)].opaque != OPAQUE_NOT {
            return DVec3::splat(0.05);
        }
        let mixed = corners.into_iter().map(|(v, w)| w * f64::from(kappa(&state.data, v as usize))).sum::<f64>();
        wide(curvature_view.color(mixed * length))
    };
    Ok((lit_from_the_eye(state, paint), curvature_view))
}

/// The picture of what pixels show, lit from the eye, in the colours that `paint` gives a hit and its triangle's
/// corners with their weights; black where there is nothing.
pub(super) fn lit_from_the_eye(state: &State, paint: impl Fn(&Hit, [(u32, f64); 3]) -> DVec3) -> Picture {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let pixel = |hit: &Hit| {
        let Some(&[a, b, c]) = data.triangles.get(hit.face as usize) else { return [0.0; 3] };
        let corners = [(a, 1.0 - f64::from(hit.u) - f64::from(hit.v)), (b, hit.u.into()), (c, hit.v.into())];
        let mix = |values: &[[f32; 3]]| corners.iter().map(|&(v, w)| w * wide(values[v as usize])).sum::<DVec3>();
        let toward = (wide(camera.origin) - mix(data.in_scene())).normalize_or_zero();
        let facing = 0.35 + 0.65 * mix(data.normals_in_scene()).normalize_or_zero().dot(toward).abs();
        narrow(facing * paint(hit, corners))
    };
    let pixels = data.hits.iter().map(pixel).collect();
    Picture::plain(camera.width as usize, camera.height as usize, pixels)
}
