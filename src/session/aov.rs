//! A picture's layers (arbitrary output variables): for each pixel, the triangle it shows and values there. A
//! triangle's own values are not interpolated.

use glam::DVec3;

use super::run::Session;
use crate::error::Result;
use crate::layout::{BufferId, Hit, NONE};
use crate::state::{State, narrow, wide};
use crate::view::aov::{Layer, Samples};

/// What the layer of the error estimate lacks where light casts shadows and `transport.subdivide` is 0.
const BORDERS: &str = "without borders of shadows within triangles: transport.subdivide = 2 puts them in";

/// The layers of a session's last picture. Numbers of links are complete only where lists are kept (`Mode::Keep`;
/// `Mode::Render` counts dark emitters, too), or where a single list holds all links.
pub fn layers(session: &mut Session) -> Result<Vec<Layer>> {
    let known = [
        BufferId::hits,
        BufferId::seen,
        BufferId::blocks,
        BufferId::irradiance,
        BufferId::lit,
        BufferId::radiosity,
        BufferId::vertex_radiosity,
        BufferId::estimate,
        BufferId::walk_noise,
        BufferId::normals,
        BufferId::placed_normals,
    ];
    session.sharpen()?;
    session.fetch(&known)?;
    session.fetch(&[BufferId::runs, BufferId::spans])?;
    let shown = Shown::new(session);
    let state = session.state();
    let data = &state.data;
    let rgb = ["R", "G", "B"];
    let normals = shown.blend(data.normals_in_scene(), |normal| narrow(normal.normalize_or_zero()));
    let mut layers = vec![
        Layer::vector("irradiance", rgb, &shown.by_triangle(&data.irradiance)),
        Layer::vector("radiosity", rgb, &shown.radiosity()),
        Layer::vector("normal", ["X", "Y", "Z"], &normals),
    ];
    layers.extend(shown.shadows());
    if state.method.estimate {
        let comment = session.leaves_out_borders().then_some(BORDERS);
        layers.push(Layer { comment, ..Layer::vector("error_estimate", rgb, &shown.estimate()) });
    }
    if !data.walk_noise.is_empty() {
        layers.push(Layer::vector("standard_error", rgb, &shown.by_triangle(&data.walk_noise)));
    }
    layers.push(Layer::single("depth", "Z", shown.depth()));
    layers.push(Layer::single("object", "id", shown.number(|face| state.object_of(face) as u32)));
    layers.push(Layer::single("triangle", "id", shown.number(|face| session.triangle(face))));
    layers.push(Layer::single("links", "count", shown.links()));
    Ok(layers)
}

/// What each pixel shows, and values there.
struct Shown<'a> {
    session: &'a Session,
    hits: Vec<Option<&'a Hit>>,
}

impl<'a> Shown<'a> {
    fn new(session: &'a Session) -> Self {
        let data = &session.state().data;
        let shows = |hit: &'a Hit| ((hit.face as usize) < data.triangles.len()).then_some(hit);
        Self { session, hits: data.hits.iter().map(shows).collect() }
    }

    /// A value in the scene's units, clamped to what `f32` can hold.
    fn light(&self, value: DVec3) -> [f32; 3] {
        narrow((value * self.session.units().light).min(DVec3::splat(f32::MAX.into())))
    }

    /// Values of the triangles.
    fn by_triangle(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.hits.iter().map(|hit| hit.map_or([0.0; 3], |hit| self.light(wide(values[hit.face as usize])))).collect()
    }

    /// Vertex values interpolated over the triangle, as in the picture.
    fn blend(&self, values: &[[f32; 3]], done: impl Fn(DVec3) -> [f32; 3]) -> Vec<[f32; 3]> {
        let triangles = &self.session.state().data.triangles;
        let mixed = |hit: &Hit| {
            let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
            let corners = triangles[hit.face as usize].iter().zip(weight);
            done(corners.map(|(&v, weight)| weight * wide(values[v as usize])).sum())
        };
        self.hits.iter().map(|hit| hit.map_or([0.0; 3], mixed)).collect()
    }

    /// The receiver that a pixel shows, and whether it is the pixel's own: else it is its triangle.
    fn receiver(&self, pixel: usize, face: usize) -> (bool, usize) {
        let state = self.session.state();
        let object = &state.objects[state.object_of(face)];
        let receiver = if object.by_pixel { state.data.seen[pixel] as usize } else { face - object.first.faces };
        (object.by_pixel, object.first.receivers + receiver)
    }

    /// Values of the receivers.
    fn received(&self, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let value = |(pixel, hit): (usize, &Option<&Hit>)| {
            hit.map_or([0.0; 3], |hit| self.light(wide(values[self.receiver(pixel, hit.face as usize).1])))
        };
        self.hits.iter().enumerate().map(value).collect()
    }

    /// Numbers of the triangles; all ones where none is seen.
    fn number(&self, number: impl Fn(usize) -> u32) -> Samples {
        Samples::Whole(self.hits.iter().map(|hit| hit.map_or(u32::MAX, |hit| number(hit.face as usize))).collect())
    }

    fn radiosity(&self) -> Vec<[f32; 3]> {
        let data = &self.session.state().data;
        let mut radiosity = self.blend(&data.vertex_radiosity, |value| self.light(value));
        let exact = self.received(&data.radiosity);
        for (pixel, hit) in self.hits.iter().enumerate() {
            if hit.is_some_and(|hit| self.receiver(pixel, hit.face as usize).0) {
                radiosity[pixel] = exact[pixel];
            }
        }
        radiosity
    }

    /// Of a triangle's rays to the lights the share that arrives; 1 where light is found at the pixels.
    fn shadows(&self) -> Option<Layer> {
        let state = self.session.state();
        let data = &state.data;
        let casting = data.lights.iter().filter(|light| light.shadow != NONE).count();
        if casting == 0 || data.lit.is_empty() {
            return None;
        }
        let words = data.object_params[0].shadow_words as usize;
        let share = |hit: &&Hit| {
            let face = hit.face as usize;
            let lit: u32 = data.lit[words * face..][..words].iter().map(|word| word.count_ones()).sum();
            let by_face = state.objects[state.object_of(face)].lit_by_face();
            if by_face { lit as f32 / casting as f32 } else { 1.0 }
        };
        let shares = self.hits.iter().map(|hit| hit.as_ref().map_or(0.0, share)).collect();
        Some(Layer::single("shadows", "lit", Samples::Float(shares)))
    }

    /// The error estimate, with what borders of shadows add to it.
    fn estimate(&self) -> Vec<[f32; 3]> {
        let mut estimate = self.received(&self.session.state().data.estimate);
        for (estimate, hit) in estimate.iter_mut().zip(&self.hits) {
            let missed = hit.map_or([0.0; 3], |hit| self.session.missed(hit.face as usize));
            *estimate = [0, 1, 2].map(|c| f64::from(estimate[c]).hypot(missed[c]).min(f32::MAX.into()) as f32);
        }
        estimate
    }

    /// Depth along the view axis, in scene units.
    fn depth(&self) -> Samples {
        let length = self.session.units().length;
        let depth = |hit: &Option<&Hit>| hit.map_or(f32::INFINITY, |hit| (f64::from(hit.depth) / length) as f32);
        Samples::Float(self.hits.iter().map(depth).collect())
    }

    /// Numbers of links.
    fn links(&self) -> Samples {
        let links = links(self.session.state());
        let value = |(pixel, hit): (usize, &Option<&Hit>)| {
            hit.map_or(0, |hit| links[self.receiver(pixel, hit.face as usize).1])
        };
        Samples::Whole(self.hits.iter().enumerate().map(value).collect())
    }
}

/// Number of emitters, clusters or triangles, whose light each receiver gathered; 0 with brute force, which keeps no
/// lists.
pub fn links(state: &State) -> Vec<u32> {
    let data = &state.data;
    let mut count = vec![0; data.radiosity.len()];
    if !data.spans.is_empty() {
        for (face, leaf) in state.faces() {
            let object = &state.objects[state.object_of(face)];
            let first = object.first.nodes;
            let mut node = leaf;
            while let Some(place) = data.topology.get(node) {
                count[object.first.receivers + face - object.first.faces] += data.spans[node].links;
                node = first.saturating_add(place.parent as usize);
            }
        }
    }
    if data.runs.is_empty() {
        return count;
    }
    for (at, batch) in state.batches() {
        let (base, first) = (state.part(BufferId::runs, at).0, state.object(at).first);
        for block in batch.clone() {
            let run = data.runs[base + (block - batch.start) as usize];
            let faces = data.blocks[first.blocks + block as usize];
            for count in &mut count[first.receivers + faces.first as usize..][..faces.count as usize] {
                *count += run.expanded + run.direct + run.area + run.edge;
            }
        }
    }
    count
}
