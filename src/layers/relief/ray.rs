//! The march beneath one visible point.

use glam::{DVec2, DVec3};

use crate::geometry::placement::turned;
use crate::layers::beneath::{optical_depth, phase, segment};
use crate::layout::{
    ABOVE_INTERFACE, FADING, GRAZING, Hit, LEAST_COSINE, Layer, Layering, Light, MAP_LAYERS, MOST_LAYERS, NONE,
};
use crate::lighting::fresnel::transmittance;
use crate::lighting::irradiance::{arrival, reaches};
use crate::lighting::texture::texel;
use crate::state::{State, wide};

/// Depths of the lower interfaces; infinite beyond the last one.
pub type Depths = [f64; MOST_LAYERS];

/// The map coordinates of a triangle's corners, and the limits of its island; in texels for maps laid out by islands.
#[derive(Clone, Copy)]
pub(super) struct MapPlaces {
    pub corners: [DVec2; 3],
    pub limits: Option<[DVec2; 2]>,
}

impl MapPlaces {
    /// The places of a triangle; none where depths are uniform.
    pub fn of(state: &State, layering: &Layering, face: usize) -> Option<Self> {
        let place = |[x, y]: [f32; 2]| DVec2::new(x.into(), y.into());
        if layering.first_island != NONE {
            let first = state.data.object_params[layering.object as usize].first_face;
            let island = &state.data.islands[face - first as usize + layering.first_island as usize];
            let limits = Some([island.low, island.high].map(place));
            return Some(Self { corners: [island.a, island.b, island.c].map(place), limits });
        }
        let uvs = (layering.size != [1, 1]).then(|| state.data.corner_uvs.get(face))??;
        Some(Self { corners: [uvs.a, uvs.b, uvs.c].map(place), limits: None })
    }
}

/// The ray beneath one visible point.
pub struct Ray<'a> {
    pub(super) state: &'a State,
    pub(super) layering: &'a Layering,
    pub(super) sigma_t: [DVec3; MOST_LAYERS],
    pub(super) face: usize,
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
    /// Normal of the fitted plane.
    pub(super) plane_normal: DVec3,
    pub(super) plane_point: DVec3,
    /// Unit direction to the eye.
    pub(super) eye: DVec3,
    place: DVec2,
    /// The first and last texel of the island with its margin, where maps are laid out by islands.
    limits: Option<[DVec2; 2]>,
    /// Gradients of the first and the second map coordinate.
    across: [DVec3; 2],
    /// Depth gained per unit length.
    pub(super) slope: f64,
    pub(super) length: f64,
}

impl<'a> Ray<'a> {
    /// The ray beneath the point that a pixel shows of an object with these layers.
    pub fn new(state: &'a State, layering: &'a Layering, hit: &Hit) -> Self {
        let (data, face) = (&state.data, hit.face as usize);
        let corners = data.triangles[face];
        let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
        let mix = |value: &dyn Fn(u32) -> DVec3| -> DVec3 { (0..3).map(|k| weight[k] * value(corners[k])).sum() };
        let [a, b, c] = corners.map(|v| wide(data.in_scene()[v as usize]));
        let point = mix(&|v| wide(data.in_scene()[v as usize]));
        let eye = (wide(data.camera[0].origin) - point).normalize_or_zero();
        let area = (b - a).cross(c - a);
        let side = if area.dot(eye) < 0.0 { -1.0 } else { 1.0 };
        let normal = mix(&|v| wide(data.normals_in_scene()[v as usize])).normalize_or_zero() * side;
        let plane = |v: u32| data.planes[v as usize];
        let turn = |v: [f32; 4]| wide(turned(&data.object_params[layering.object as usize], [v[0], v[1], v[2]]));
        let fitted = mix(&|v| turn(plane(v))).normalize_or_zero();
        let height: f64 = (0..3).map(|k| weight[k] * f64::from(plane(corners[k])[3])).sum();

        // Gradients g of the map coordinates: (b - a) . g is the difference along that edge, and g lies in the
        // triangle's plane.
        let (mut across, mut at) = ([DVec3::ZERO; 2], DVec2::ZERO);
        let map = MapPlaces::of(state, layering, face);
        if let Some(MapPlaces { corners: [p, q, r], .. }) = map {
            at = weight[0] * p + weight[1] * q + weight[2] * r;
            let square = area.length_squared();
            if square > 0.0 {
                let along = [area.cross(c - a) / square, area.cross(b - a) / square];
                let gradient = |k: usize| along[1] * (r - p)[k] - along[0] * (q - p)[k];
                across = [gradient(0), gradient(1)];
            }
        }
        let slope = (fitted * side).dot(eye).max(GRAZING);
        let length = (f64::from(layering.deepest) / slope).min(layering.reach.into());
        let layers = &data.layer_media[layering.first_layer as usize..][..layering.layers as usize];
        let mut sigma_t = [DVec3::ZERO; MOST_LAYERS];
        sigma_t.iter_mut().zip(layers).for_each(|(sigma, layer)| *sigma = wide(layer.sigma_t));
        Self {
            state,
            layering,
            sigma_t,
            face,
            point,
            normal,
            plane_normal: fitted * side,
            plane_point: point + height * fitted,
            eye,
            place: at,
            limits: map.and_then(|map| map.limits),
            across,
            slope,
            length,
        }
    }

    pub(super) fn layers(&self) -> &[Layer] {
        &self.state.data.layer_media[self.layering.first_layer as usize..][..self.layering.layers as usize]
    }

    /// Depths of the lower interfaces at an offset from P; infinite beyond the last one.
    pub(super) fn depths(&self, offset: DVec3) -> Depths {
        let place = self.place + DVec2::new(self.across[0].dot(offset), self.across[1].dot(offset));
        self.depths_of(place, self.limits)
    }

    /// Depths of the lower interfaces at map coordinates, within the limits of the island.
    pub(super) fn depths_of(&self, place: DVec2, limits: Option<[DVec2; 2]>) -> Depths {
        let [width, height] = self.layering.size;
        let at = match limits {
            Some([low, high]) => place.clamp(low, high),
            None => place * DVec2::new(width.into(), height.into()) - 0.5,
        };
        let (left, top) = (at.x.floor(), at.y.floor());
        let column = |i: f64| texel(i as i64, width, self.layering.wrap);
        let row = |i: f64| texel(i as i64, height, self.layering.wrap) * width;
        let corners = [(left, top), (left + 1.0, top), (left, top + 1.0), (left + 1.0, top + 1.0)];
        let corners = corners.map(|(x, y)| self.layering.first_texel + row(y) + column(x));
        let [right, below] = [at.x - left, at.y - top];
        let weights = [(1.0 - right) * (1.0 - below), right * (1.0 - below), (1.0 - right) * below, right * below];
        let mut depths = [f64::INFINITY; MOST_LAYERS];
        for (layer, depth) in depths.iter_mut().enumerate().take(self.layering.layers as usize) {
            let map = (layer / MAP_LAYERS) as u32 * width * height;
            let value = |corner: u32| f64::from(self.state.data.depths[(corner + map) as usize][layer % MAP_LAYERS]);
            *depth = corners.iter().zip(weights).map(|(&corner, weight)| weight * value(corner)).sum();
        }
        depths
    }

    /// For a light, at distance `t` along the ray: the unattenuated light, the optical depth of its leg, and the
    /// cosine for the phase function. `depths` are the interface depths at that point.
    fn light(&self, light: &Light, t: f64, depths: &Depths) -> (DVec3, DVec3, f64) {
        let place = self.point - t * self.eye;
        let (toward, falloff) = arrival(light, place);

        // The plane interpolated between the tangent plane and the fitted one, and where light enters through it.
        let share = t / self.length;
        let normal = self.normal.lerp(self.plane_normal, share).normalize_or_zero();
        let depth = (self.point.lerp(self.plane_point, share) - place).dot(normal).max(0.0);
        let facing = normal.dot(toward);
        let (cosine, falloff) = (facing.max(LEAST_COSINE), falloff * (facing / FADING).clamp(0.0, 1.0));
        let entry = self.depths(place + toward * (depth / cosine) - self.point);

        let sigma_t = &self.sigma_t[..self.layering.layers as usize];
        let dimmed = optical_depth(sigma_t, |j| 0.5 * (depths[j] + entry[j]), depth, cosine);
        (self.transmitted(cosine) * falloff, dimmed, toward.dot(self.eye))
    }

    /// Fresnel transmittance, or 1 where it is switched off.
    pub(super) fn transmitted(&self, cosine: f64) -> DVec3 {
        if self.layering.fresnel == 0 {
            return DVec3::ONE;
        }
        let eta = self.state.data.object_params[self.layering.object as usize].eta;
        DVec3::from_array(eta.map(|eta| transmittance(eta.into(), cosine)))
    }

    fn layer(&self, t: f64, depths: &Depths) -> usize {
        depths.iter().filter(|&&depth| self.slope * t >= depth).count()
    }

    fn depths_at(&self, t: f64) -> Depths {
        self.depths(-t * self.eye)
    }

    /// Splits the ray into parts, each within one layer and one step.
    fn parts(&self) -> Vec<Part> {
        let steps = self.layering.samples;
        let at = |i: u32| self.length * f64::from(i) / f64::from(steps);
        let mut parts = Vec::new();
        let mut before = self.depths_at(0.0);
        for i in 0..steps {
            let (from, to) = (at(i), at(i + 1));
            let after = self.depths_at(to);
            let (mut now, last) = (self.layer(from, &before), self.layer(to, &after));
            let crossing = |interface: usize| {
                let (a, b) = (self.slope * from - before[interface], self.slope * to - after[interface]);
                (a / (a - b)).clamp(0.0, 1.0)
            };
            let within = |share: f64| -> (f64, Depths) {
                let depths = std::array::from_fn(|j| {
                    if before[j] < 1e30 { before[j] + (after[j] - before[j]) * share } else { f64::INFINITY }
                });
                (from + (to - from) * share, depths)
            };
            let mut share = 0.0;
            while now != last {
                let next = crossing(if now < last { now } else { now - 1 }).max(share);
                parts.push(Part { from: within(share), to: within(next), layer: now });
                (share, now) = (next, if now < last { now + 1 } else { now - 1 });
            }
            parts.push(Part { from: within(share), to: (to, after), layer: now });
            before = after;
        }
        parts
    }

    /// Radiance due to a light of intensity 1, in closed form for each part.
    fn exact(&self, light: &Light, parts: &[Part]) -> DVec3 {
        let (layers, henyey) = (self.layers(), self.layering.henyey != 0);
        let (mut sum, mut above) = (DVec3::ZERO, DVec3::ZERO);
        for part in parts {
            let layer = &layers[part.layer.min(layers.len() - 1)];
            let (length, g) = (part.to.0 - part.from.0, f64::from(layer.g));
            let below = above + wide(layer.sigma_t) * length;
            if part.layer < layers.len() {
                let [a, b] = [&part.from, &part.to].map(|(t, depths)| self.light(light, *t, depths));
                let (p, q) = (a.0 * phase(henyey, g, a.2), b.0 * phase(henyey, g, b.2));
                let (near, far) = (above + a.1, below + b.1);
                let channel = |c: usize| segment(p[c], q[c], near[c], far[c]);
                sum += wide(layer.sigma_s) * DVec3::new(channel(0), channel(1), channel(2)) * length;
            }
            above = below;
        }
        sum
    }

    /// Radiance due to a light of intensity 1, by the paper's left rule.
    fn paper(&self, light: &Light) -> DVec3 {
        let (layers, henyey) = (self.layers(), self.layering.henyey != 0);
        let step = self.length / f64::from(self.layering.samples);
        let (mut sum, mut dimmed) = (DVec3::ZERO, DVec3::ONE);
        for i in 0..=self.layering.samples {
            let t = step * f64::from(i);
            let depths = self.depths_at(t);
            let number = self.layer(ABOVE_INTERFACE * t, &depths);
            let layer = &layers[number.min(layers.len() - 1)];
            if number < layers.len() {
                let (arrives, depth, cosine) = self.light(light, t, &depths);
                let p = phase(henyey, layer.g.into(), cosine);
                sum += wide(layer.sigma_s) * arrives * (-depth).exp() * dimmed * (p * step);
            }
            dimmed *= (-wide(layer.sigma_t) * step).exp();
        }
        sum
    }

    /// Radiance towards the eye, internal units.
    pub fn radiance(&self) -> DVec3 {
        if self.length <= 0.0 {
            return DVec3::ZERO;
        }
        let data = &self.state.data;
        let lights = data.layer_lights.iter().filter(|light| reaches(data, light, self.face));
        let parts = if self.layering.paper == 0 { self.parts() } else { Vec::new() };
        let one = |light| if self.layering.paper == 0 { self.exact(light, &parts) } else { self.paper(light) };
        let sum: DVec3 = lights.map(|light| one(light) * wide(light.color)).sum();
        sum * self.transmitted(self.normal.dot(self.eye).abs())
    }
}

/// A part of a ray within one layer: for both ends, the distance along the ray and the interface depths there.
struct Part {
    from: (f64, Depths),
    to: (f64, Depths),
    layer: usize,
}
