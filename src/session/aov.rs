//! A picture's layers (arbitrary output variables): for each pixel, the triangle it shows and values there. A
//! triangle's own values are not interpolated.

use glam::DVec3;

use super::run::Session;
use crate::error::Result;
use crate::layout::{BufferId, Hit, NONE};
use crate::state::{State, narrow, wide};
use crate::view::aov::{Layer, Samples};

/// A note on what the layer of the error estimate lacks where light casts shadows and `transport.subdivide` is 0.
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
    let (state, units) = (session.state(), *session.units());
    let data = &state.data;
    // Clamped to what `f32` can hold.
    let light = |value: DVec3| narrow((value * units.light).min(DVec3::splat(f32::MAX.into())));

    let links = links(state);
    let shown: Vec<Option<&Hit>> =
        data.hits.iter().map(|hit| ((hit.face as usize) < data.triangles.len()).then_some(hit)).collect();
    let own = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
        shown.iter().map(|hit| hit.map_or([0.0; 3], |hit| light(wide(values[hit.face as usize])))).collect()
    };
    // Vertex values interpolated over the triangle, as in the picture.
    let blend = |values: &[[f32; 3]], done: &dyn Fn(DVec3) -> [f32; 3]| -> Vec<[f32; 3]> {
        let mixed = |hit: &Hit| {
            let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
            let corners = data.triangles[hit.face as usize].iter().zip(weight);
            done(corners.map(|(&v, weight)| weight * wide(values[v as usize])).sum())
        };
        shown.iter().map(|hit| hit.map_or([0.0; 3], mixed)).collect()
    };
    // Values at the receiver: the pixel's own, or its triangle.
    let receiver = |pixel: usize, face: usize| {
        let object = &state.objects[state.object_of(face)];
        let own = if object.by_pixel { data.seen[pixel] as usize } else { face - object.first.faces };
        (object.by_pixel, object.first.receivers + own)
    };
    let received = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let of = |(pixel, hit): (usize, &Option<&Hit>)| {
            hit.map_or([0.0; 3], |hit| light(wide(values[receiver(pixel, hit.face as usize).1])))
        };
        shown.iter().enumerate().map(of).collect()
    };
    let mut radiosity = blend(&data.vertex_radiosity, &light);
    let exact = received(&data.radiosity);
    for (pixel, hit) in shown.iter().enumerate() {
        if hit.is_some_and(|hit| receiver(pixel, hit.face as usize).0) {
            radiosity[pixel] = exact[pixel];
        }
    }
    let number = |nothing: u32, of: &dyn Fn(usize) -> u32| {
        Samples::Whole(shown.iter().map(|hit| hit.map_or(nothing, |hit| of(hit.face as usize))).collect())
    };

    let of_link =
        |(pixel, hit): (usize, &Option<&Hit>)| hit.map_or(0, |hit| links[receiver(pixel, hit.face as usize).1]);
    let of_links = Samples::Whole(shown.iter().enumerate().map(of_link).collect());
    let rgb = ["R", "G", "B"];
    let normals = blend(data.normals_in_scene(), &|normal| narrow(normal.normalize_or_zero()));
    let mut layers = vec![
        Layer::vector("irradiance", rgb, &own(&data.irradiance)),
        Layer::vector("radiosity", rgb, &radiosity),
        Layer::vector("normal", ["X", "Y", "Z"], &normals),
    ];
    let casting = data.lights.iter().filter(|light| light.shadow != NONE).count();
    if casting > 0 && !data.lit.is_empty() {
        // Of a triangle's rays to the lights the share that arrives; 1 where light is found at the pixels.
        let words = data.object_params[0].shadow_words as usize;
        let share = |hit: &&Hit| {
            let face = hit.face as usize;
            let lit: u32 = data.lit[words * face..][..words].iter().map(|word| word.count_ones()).sum();
            let by_face = state.objects[state.object_of(face)].lit_by_face();
            if by_face { lit as f32 / casting as f32 } else { 1.0 }
        };
        let shares = shown.iter().map(|hit| hit.as_ref().map_or(0.0, share)).collect();
        layers.push(Layer::single("shadows", "lit", Samples::Float(shares)));
    }
    if state.method.estimate {
        let mut estimate = received(&data.estimate);
        for (estimate, hit) in estimate.iter_mut().zip(&shown) {
            let missed = hit.map_or([0.0; 3], |hit| session.missed(hit.face as usize));
            *estimate = [0, 1, 2].map(|c| f64::from(estimate[c]).hypot(missed[c]).min(f32::MAX.into()) as f32);
        }
        let comment = session.leaves_out_borders().then_some(BORDERS);
        layers.push(Layer { comment, ..Layer::vector("error_estimate", rgb, &estimate) });
    }
    if !data.walk_noise.is_empty() {
        layers.push(Layer::vector("standard_error", rgb, &own(&data.walk_noise)));
    }
    // Depth along the view axis, in scene units.
    let depth = |hit: &Option<&Hit>| hit.map_or(f32::INFINITY, |hit| (f64::from(hit.depth) / units.length) as f32);
    layers.push(Layer::single("depth", "Z", Samples::Float(shown.iter().map(depth).collect())));
    layers.push(Layer::single("object", "id", number(u32::MAX, &|face| state.object_of(face) as u32)));
    layers.push(Layer::single("triangle", "id", number(u32::MAX, &|face| session.triangle(face))));
    layers.push(Layer::single("links", "count", of_links));
    Ok(layers)
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
