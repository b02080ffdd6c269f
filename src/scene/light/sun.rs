//! The sun of an environment's image: a place so small and so bright that it is better a light with one direction. It
//! is taken out of the image, so that image and light together are as bright as before.

use super::Sky;
use glam::{DQuat, DVec3};
use std::collections::HashSet;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How many times as bright as its dimmest pixels, and those around it, the brightest pixel is.
const CONTRAST: f64 = 50.0;
/// Its largest solid angle: that of a disc with a radius of 2.5 degrees.
const LARGEST: f64 = 6e-3;
/// How much of its light arrives on a plane perpendicular to its direction, at least: less if it is a line, not a disc.
const ROUND: f64 = 0.999;
/// Its least irradiance, as a share of what the rest of the image gives on average.
const WEAKEST: f64 = 0.1;

/// A sun. Directions are those of an environment that is not rotated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sun {
    /// Towards it, length 1.
    direction: DVec3,
    /// Irradiance on a plane perpendicular to the direction, of the image's pixels.
    irradiance: DVec3,
    /// 1 - cos of its radius.
    narrowness: f64,
}

impl std::fmt::Display for Sun {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let degrees = (1.0 - self.narrowness).acos().to_degrees();
        let [x, y, z] = self.direction.to_array();
        write!(
            out,
            "a sun at [{x:.3}, {y:.3}, {z:.3}] in the image, {degrees:.2} degrees in radius, is a light of its own"
        )
    }
}

/// The pixels of the sun, and those around it; none if its place is too large.
fn region(sky: &Sky, brightest: usize, light: &dyn Fn(usize) -> f64) -> Option<[Vec<usize>; 2]> {
    let [width, height] = sky.size.map(|side| side as usize);
    let (mut inside, mut around, mut known) = (vec![brightest], Vec::new(), HashSet::from([brightest]));
    let (mut next, mut angle) = (0, 0.0);
    while let Some(&pixel) = inside.get(next) {
        next += 1;
        let (column, row) = (pixel % width, pixel / width);
        angle += sky.angle(row as u32);
        if angle > LARGEST {
            return None;
        }
        let columns = [column + width - 1, column, column + 1].map(|column| column % width);
        for place in (row.saturating_sub(1)..(row + 2).min(height)).flat_map(|row| columns.map(|c| row * width + c)) {
            if known.insert(place) {
                let sun = light(place) * CONTRAST >= light(brightest);
                if sun { &mut inside } else { &mut around }.push(place);
            }
        }
    }
    (!around.is_empty()).then_some([inside, around])
}

impl Sky {
    /// The solid angle of a pixel of this row.
    fn angle(&self, row: u32) -> f64 {
        (self.polar(row).cos() - self.polar(row + 1).cos()) * TAU / f64::from(self.size[0])
    }

    /// The same sky, whose sun, if it has one, is a light of its own ([`Self::sun`]).
    #[must_use]
    pub fn with_sun(mut self) -> Self {
        let wide = |pixel: [f32; 3]| DVec3::from_array(pixel.map(f64::from));
        let light = |pixel: usize| wide(self.pixels[pixel]).element_sum();
        let brightest = (0..self.pixels.len()).max_by(|&a, &b| light(a).total_cmp(&light(b)));
        let Some([inside, mut around]) = brightest.and_then(|brightest| region(&self, brightest, &light)) else {
            return self;
        };
        // The sky behind it is that around it: the median, since its edge may lie in some of those pixels, too.
        around.sort_by(|&a, &b| light(a).total_cmp(&light(b)));
        let behind = wide(self.pixels[around[around.len() / 2]]);
        let rest = |pixel: usize| wide(self.pixels[pixel]).min(behind);
        let angle: f64 = inside.iter().map(|&pixel| self.angle((pixel / self.size[0] as usize) as u32)).sum();
        let (mut flux, mut whole, all) = ([DVec3::ZERO; 3], DVec3::ZERO, [inside, around].concat());
        for &pixel in &all {
            let [column, row] = [pixel % self.size[0] as usize, pixel / self.size[0] as usize].map(|n| n as u32);
            let (t, a) = (0.5 * (self.polar(row) + self.polar(row + 1)), TAU * (f64::from(column) + 0.5));
            let a = a / f64::from(self.size[0]) - PI;
            let way = DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos());
            let share = (wide(self.pixels[pixel]) - rest(pixel)) * self.angle(row);
            whole += share;
            (0..3).for_each(|c| flux[c] += share[c] * way);
        }
        let direction = flux.iter().sum::<DVec3>().normalize_or_zero();
        let irradiance = DVec3::from_array(flux.map(|flux| flux.dot(direction).max(0.0)));
        // The factor on the image does not matter.
        let mut plain = self.clone();
        plain.factor = [1.0; 3];
        let mean = plain.mean();
        let (sum, others) = (irradiance.element_sum(), PI * mean.element_sum() - irradiance.element_sum() / 4.0);
        let is_one = sum >= WEAKEST * others && sum >= ROUND * whole.element_sum() && direction != DVec3::ZERO;
        if !is_one || !irradiance.is_finite() {
            return self;
        }
        let dimmed: Vec<_> = all.iter().map(|&pixel| (pixel, rest(pixel).as_vec3().to_array())).collect();
        let pixels = Arc::make_mut(&mut self.pixels);
        dimmed.into_iter().for_each(|(pixel, rest)| pixels[pixel] = rest);
        self.sun = Some(Sun { direction, irradiance, narrowness: angle / TAU });
        self
    }

    /// The sun that was taken out of the image: the direction towards it, its irradiance on a plane perpendicular to
    /// that, r g b, and 1 - cos of its radius.
    pub fn sun(&self) -> Option<(DVec3, [f64; 3], f64)> {
        let sun = self.sun?;
        let turned = DQuat::from_rotation_y(self.rotation.to_radians()) * sun.direction;
        Some((turned, (sun.irradiance * DVec3::from_array(self.factor)).to_array(), sun.narrowness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky of 1 with a disc of this radiance, in degrees; its pixels are the means of 1024 places.
    fn disc(width: u32, toward: DVec3, radius: f64, radiance: f64) -> Sky {
        let height = width / 2;
        let off = |x: f64, y: f64| {
            let (t, a) = (PI * y / f64::from(height), TAU * (x / f64::from(width) - 0.5));
            DVec3::new(t.sin() * a.sin(), t.cos(), -t.sin() * a.cos()).angle_between(toward).to_degrees()
        };
        let pixel = |k: u32| {
            let (x, y) = (f64::from(k % width), f64::from(k / width));
            let part = |n: u32| (f64::from(n) + 0.5) / 32.0;
            let near = off(x + 0.5, y + 0.5) < radius + 360.0 / f64::from(width);
            let inside = |n: &u32| off(x + part(n % 32), y + part(n / 32)) < radius;
            let share = if near { (0..1024).filter(inside).count() as f64 / 1024.0 } else { 0.0 };
            let red = 1.0 + share * (radiance - 1.0);
            [red as f32, 0.5 * red as f32, 0.5]
        };
        Sky::new([width, height], (0..width * height).map(pixel).collect())
    }

    #[test]
    fn a_disc_is_found_where_it_is_as_bright_as_it_is() {
        for (toward, radius, width) in [
            (DVec3::new(0.3, 0.5, -0.7), 0.5, 512),
            (DVec3::new(0.02, 0.4, 1.0), 1.3, 256),
            (DVec3::new(0.1, 1.0, 0.05), 2.0, 256),
        ] {
            let (toward, before) = (toward.normalize(), disc(width, toward.normalize(), radius, 9e4));
            let mut after = before.clone().with_sun();
            let (direction, [red, green, blue], narrowness) = after.sun().unwrap();
            let exact = 9e4 * PI * radius.to_radians().sin().powi(2);
            println!("{:.4} pixels, {:.5}", direction.angle_between(toward) / PI * f64::from(width / 2), red / exact);
            assert!(direction.angle_between(toward) < 0.5 * PI / f64::from(width / 2), "{direction} {toward}");
            assert!((red / exact - 1.0).abs() < 0.01 && (2.0 * green / red - 1.0).abs() < 1e-4 && blue == 0.0, "{red}");
            assert!((1.0 - narrowness).acos().to_degrees() < 1.5 * radius + 180.0 / f64::from(width));
            // Whatever the factor.
            for factor in [[0.01; 3], [100.0; 3]] {
                let mut other = before.clone();
                other.factor = factor;
                assert_eq!(other.with_sun().sun, after.sun);
            }
            // Nothing is lost, and nothing stays.
            assert!((after.mean() / before.mean() - 1.0).abs().max_element() < 1e-3);
            assert!(after.brightest()[0] < 9e4 / CONTRAST);
            // It turns and scales with the image.
            (after.rotation, after.factor) = (90.0, [2.0, 1.0, 1.0]);
            let (turned, [double, ..], _) = after.sun().unwrap();
            assert!((turned.x - direction.z).abs() < 1e-9 && double == 2.0 * red, "{turned}");
        }
    }

    #[test]
    fn what_is_large_weak_or_no_brighter_than_the_rest_is_no_sun() {
        let toward = DVec3::new(0.3, 0.5, -0.7).normalize();
        for (radius, radiance) in [(3.0, 9e4), (0.5, 30.0), (0.5, 200.0)] {
            let sky = disc(256, toward, radius, radiance);
            assert_eq!(sky.clone().with_sun(), sky, "{radius} {radiance}");
        }
        // A bright line of 20 degrees, no larger than a sun.
        let line = |k: usize| if k / 512 == 100 && k % 512 < 28 { [9e4; 3] } else { [1.0; 3] };
        let sky = Sky::new([512, 256], (0..512 * 256).map(line).collect());
        assert_eq!(sky.clone().with_sun(), sky);
        for pixels in [Vec::new(), vec![[0.0; 3]; 4], vec![[f32::MAX; 3]; 4]] {
            let sky = Sky::new([pixels.len() as u32, 1], pixels);
            assert!(sky.with_sun().sun().is_none());
        }
    }
}
