//! What will take long in a frame, from a sample of it before it runs: rays and the triangles' boxes that they meet,
//! and pairs of a receiver with a triangle so near, for its size, that equation 6 has to be integrated over it.
//!
//! A hierarchy spares work only where triangles are small against their distance. The long, thin ones of a fan lie
//! across one another's boxes, and each is near to most of the others: both numbers then grow with the triangles'
//! square.

use rayon::prelude::*;

use super::run::Session;
use crate::geometry::placement::placed;
use crate::geometry::trace::may_meet;
use crate::layout::{
    Camera, LIGHT_BRIGHT_RAY, LIGHT_DIRECTIONAL, LIGHT_MIRROR_RAY, LIGHT_SKY_RAY, Light, NONE, REFLECTION_NONE,
};
use crate::lighting::pixel_light::pixel_light;
use crate::lighting::shadow;
use crate::state::State;
use crate::transport::blocks::gather;
use crate::transport::links::refine;
use crate::view::{pixel_shadow, visibility};

/// Most rays and receivers of a sample.
const SAMPLE: usize = 128;
/// Most triangles that each is compared with.
const AGAINST: usize = 4096;
/// Square of the distance within which a triangle is near, per trace of its second moment: an even triangle then has
/// about six neighbours.
const NEAR: f32 = 9.0;

/// Rays of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct Rays {
    /// The stage that casts them.
    pub stage: &'static str,
    /// What the rays start at, one a light sample: `triangles` or `pixels`.
    pub per: &'static str,
    /// How many of those there are.
    pub places: u64,
    /// Light samples that cast shadows; none for rays of the camera.
    pub samples: Option<u64>,
    /// Share of them that are cast, estimated: not where triangles are turned away from a light, nor by pixels that
    /// show no opaque object.
    pub share: f64,
    /// Boxes of triangles along a ray that is cast, on average, estimated.
    pub boxes: f64,
}

impl Rays {
    /// Number of rays, at most: some places need none.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.places * self.samples.unwrap_or(1)
    }

    /// Boxes that all rays are tested with, estimated: of nodes down to the triangles in a tree of even ones
    /// (measured: six a level), and of the triangles along the ray with the nodes just above them.
    #[must_use]
    pub fn work(&self, triangles: usize) -> f64 {
        self.count() as f64 * self.share * (6.0 * (triangles.max(2) as f64).log2() + 2.0 * self.boxes)
    }
}

/// What will take long in a frame from scratch, estimated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Workload {
    /// Triangles of all objects.
    pub triangles: usize,
    /// Rays of each stage that casts any, in the order of the frame.
    pub rays: Vec<Rays>,
    /// Triangles near a receiver, on average; 0 where no light is carried by the hierarchy.
    pub near: f64,
    /// Receivers of light.
    pub receivers: u64,
}

impl Workload {
    /// Pairs of a receiver and a triangle near it.
    #[must_use]
    pub fn pairs(&self) -> f64 {
        self.near * self.receivers as f64
    }
}

impl Session {
    /// Estimates the work of a frame from scratch; a few milliseconds.
    #[must_use]
    pub fn workload(&self) -> Workload {
        let (state, plan) = (self.state(), self.plan());
        let (extent, pixels) = (state.extent(), state.pixels());
        let faces = Places::new(state, |_| true);
        let casting: Vec<&Light> = state.data.lights.iter().filter(|light| light.shadow != NONE).collect();
        let mut load = Workload { triangles: extent.faces, ..Workload::default() };
        if plan.has(&shadow::STAGE) {
            let lit = |object: usize| state.objects[object].lit_by_face();
            let places = state.objects.iter().filter(|object| object.lit_by_face()).map(|object| object.count.faces);
            let (places, samples) = (places.sum::<usize>() as u64, Some(casting.len() as u64));
            let [share, boxes] =
                faces.shadowed(&Places::new(state, lit), casting.len(), |number, _, _| *casting[number]);
            load.rays.push(Rays { stage: shadow::STAGE.name, per: "triangles", places, samples, share, boxes });
        }
        let sight: Vec<_> = state.data.camera.first().map_or(Vec::new(), some_rays);
        if plan.has(&visibility::STAGE) {
            let along: Vec<f64> = sight.par_iter().map(|&[origin, direction]| faces.along(origin, direction)).collect();
            let boxes = mean(along.into_iter());
            let (stage, places) = (visibility::STAGE.name, pixels as u64);
            load.rays.push(Rays { stage, per: "pixels", places, samples: None, share: 1.0, boxes });
        }
        if plan.has(&pixel_shadow::STAGE) {
            let asks = |object: usize| {
                state.objects[object].plain() || state.data.object_params[object].reflection != REFLECTION_NONE
            };
            let asking = Places::new(state, asks);
            let lights = &state.data.pixel_lights;
            let casting: Vec<usize> = (0..lights.len()).filter(|&number| lights[number].shadow != NONE).collect();
            let samples = Some(casting.len() as u64);
            // Rays of reflections are taken to go along the normal.
            let light = |number: usize, k, normal| match lights[casting[number]].kind {
                LIGHT_MIRROR_RAY | LIGHT_BRIGHT_RAY => {
                    Light { kind: LIGHT_DIRECTIONAL, place: normal, ..Light::default() }
                }
                _ => pixel_light(&state.data, casting[number], k, normal),
            };
            let [facing, boxes] = faces.shadowed(&asking, casting.len(), light);
            let shown =
                mean(sight.iter().map(|&[origin, direction]| f64::from(u8::from(asking.ahead(origin, direction)))));
            let (stage, places, share) = (pixel_shadow::STAGE.name, pixels as u64, shown * facing);
            load.rays.push(Rays { stage, per: "pixels", places, samples, share, boxes });
        }
        if plan.has(&gather::STAGE) || plan.has(&refine::STAGE) {
            // Objects exchange no light.
            for (number, object) in state.objects.iter().enumerate().filter(|(_, object)| !object.opaque) {
                load.receivers += object.count.receivers as u64;
                load.near += object.count.receivers as f64 * Places::new(state, |other| other == number).near();
            }
            load.near /= load.receivers.max(1) as f64;
        }
        load
    }
}

/// Evenly spread triangles of some objects: corners and centroids.
struct Places {
    corners: Vec<[[f32; 3]; 3]>,
    /// How many triangles each stands for.
    each: f64,
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
    if count > 0 { sum / f64::from(count) } else { 0.0 }
}

/// Origin and direction of the rays through some pixels, spread by the two-dimensional golden ratio.
fn some_rays(camera: &Camera) -> Vec<[[f32; 3]; 2]> {
    let pixel = |k: usize| {
        let at = |ratio: f64, side: u32| ((ratio * k as f64).fract() * f64::from(side)) as u32;
        camera.width * at(0.569_840_290_998, camera.height) + at(0.754_877_666_247, camera.width)
    };
    (1..=SAMPLE).map(|k| [camera.origin, visibility::ray(camera, pixel(k))]).collect()
}

fn centroid(corners: &[[f32; 3]; 3]) -> [f32; 3] {
    std::array::from_fn(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0)
}

fn square(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

impl Places {
    fn new(state: &State, includes: impl Fn(usize) -> bool) -> Self {
        let data = &state.data;
        let objects = state.objects.iter().enumerate().filter(|(number, _)| includes(*number));
        let all: Vec<(usize, usize)> = objects
            .flat_map(|(number, object)| (0..object.count.faces).map(move |face| (number, object.first.faces + face)))
            .collect();
        let step = all.len().div_ceil(AGAINST).max(1);
        let taken = all.iter().skip(step / 2).step_by(step);
        // No frame has run yet that would have placed the vertices.
        let place = |object: usize, v: u32| placed(&data.object_params[object], data.positions[v as usize]);
        let corners: Vec<_> = taken.map(|&(object, face)| data.triangles[face].map(|v| place(object, v))).collect();
        Self { each: all.len() as f64 / corners.len().max(1) as f64, corners }
    }

    /// Some of the triangles, at most [`SAMPLE`].
    fn some(&self) -> impl Iterator<Item = &[[f32; 3]; 3]> {
        let step = self.corners.len().div_ceil(SAMPLE).max(1);
        self.corners.iter().skip(step / 2).step_by(step)
    }

    /// Boxes along a ray, behind what it hits, too.
    fn along(&self, origin: [f32; 3], direction: [f32; 3]) -> f64 {
        let met = |corners: &&[[f32; 3]; 3]| {
            let side = |end: fn(f32, f32) -> f32| {
                std::array::from_fn(|k| end(end(corners[0][k], corners[1][k]), corners[2][k]))
            };
            may_meet(side(f32::min), side(f32::max), origin, direction)
        };
        self.each * self.corners.iter().filter(met).count() as f64
    }

    /// Whether a ray may meet the box around all of them.
    fn ahead(&self, origin: [f32; 3], direction: [f32; 3]) -> bool {
        let corners = || self.corners.iter().flatten().map(|&corner| glam::Vec3::from(corner));
        let low = corners().fold(glam::Vec3::INFINITY, glam::Vec3::min);
        let high = corners().fold(glam::Vec3::NEG_INFINITY, glam::Vec3::max);
        !self.corners.is_empty() && may_meet(low.into(), high.into(), origin, direction)
    }

    /// Share of pairs of one of these places and a light whose ray is cast, and boxes along such a ray, on average.
    /// `light` is the light of a number below `lights`, as place k with this normal sees it.
    fn shadowed(
        &self,
        places: &Self,
        lights: usize,
        light: impl Fn(usize, usize, [f32; 3]) -> Light + Sync,
    ) -> [f64; 2] {
        if places.corners.is_empty() || lights == 0 {
            return [0.0; 2];
        }
        let boxes_of = |k: usize| {
            // Another light each time, spread over all of them by the golden ratio.
            let spread = (k as f64 * 0.618_033_988_75).fract() * lights as f64;
            let corners = &places.corners[k * places.corners.len() / SAMPLE];
            let [a, b, c] = corners.map(glam::Vec3::from);
            let normal = (b - a).cross(c - a);
            let (light, origin) = (light(spread as usize, k, normal.into()), centroid(corners));
            let far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
            let direction = if far { light.place } else { std::array::from_fn(|k| light.place[k] - origin[k]) };
            (normal.dot(direction.into()) > 0.0).then(|| self.along(origin, direction))
        };
        let boxes: Vec<f64> = (0..SAMPLE).into_par_iter().filter_map(boxes_of).collect();
        [boxes.len() as f64 / SAMPLE as f64, mean(boxes.into_iter())]
    }

    /// Triangles near one of them, on average.
    fn near(&self) -> f64 {
        // The trace of a triangle's second moment: its edges' squares over 36.
        let reach = |t: &[[f32; 3]; 3]| NEAR * (square(t[0], t[1]) + square(t[1], t[2]) + square(t[2], t[0])) / 36.0;
        let known: Vec<_> = self.corners.iter().map(|corners| (centroid(corners), reach(corners))).collect();
        let some: Vec<_> = self.some().collect();
        let near = |corners: &&[[f32; 3]; 3]| {
            let place = centroid(corners);
            self.each * known.iter().filter(|(center, reach)| square(place, *center) <= *reach).count() as f64
        };
        mean(some.par_iter().map(near).collect::<Vec<_>>().into_iter())
    }
}
