//! The candle: a slightly tapered body of wax with a rounded foot, a soft uneven rim, and a hollow burnt into its top,
//! in which a flame can hang.

use super::Mesh;
use super::sweep::{smooth, sweep};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radii at the foot and the top, and the height of the rim.
const FOOT: f64 = 0.36;
const TOP: f64 = 0.32;
const HEIGHT: f64 = 1.0;

/// Radii of the rounding at the foot, and of the rim.
const ROUND: f64 = 0.05;
const RIM: f64 = 0.045;

/// Depth of the hollow.
const HOLLOW: f64 = 0.16;

/// Amplitude of the rim's waves.
const WAVE: f64 = 0.018;

/// A closed candle with `cells` around the circle, 1 high.
pub(super) fn candle(cells: u32) -> Mesh {
    // Steps of the outline about as long as a cell is wide.
    let outline = outline(std::f64::consts::TAU * TOP / f64::from(cells));
    let widest = outline.iter().fold(0.0, |most: f64, p| most.max(p.x));
    let last = outline.len() - 1;
    let count = |(ring, p): (usize, &DVec2)| {
        if ring == 0 || ring == last {
            return 1;
        }
        // Fewer cells where the circle gets small, halved as often as the count allows.
        let mut count = cells;
        let mut radius = widest / 2.0;
        while p.x < radius && count.is_multiple_of(2) && count >= 12 {
            (count, radius) = (count / 2, radius / 2.0);
        }
        count
    };
    let counts: Vec<u32> = outline.iter().enumerate().map(count).collect();
    sweep(&counts, |ring, angle| {
        let p = outline[ring];
        let wave = (2.0 * angle + 0.4).sin() + 0.6 * (3.0 * angle + 2.0).sin() + 0.3 * (7.0 * angle).sin();
        let share = smooth(0.6, 1.0, p.y) * smooth(0.0, 0.8 * TOP, p.x);
        DVec3::new(p.x * angle.cos(), p.y + WAVE * wave * share, p.x * angle.sin())
    })
}

/// Radius and height from the middle of the bottom, up the side, over the rim, to the middle of the hollow.
fn outline(step: f64) -> Vec<DVec2> {
    let side = DVec2::new(TOP - FOOT, HEIGHT - RIM - ROUND);
    let lean = (-side.x / side.y).atan();
    let arc = |middle: DVec2, radius: f64, from: f64, to: f64| {
        move |t: f64| middle + radius * DVec2::from_angle(from + (to - from) * t)
    };
    let foot = arc(DVec2::new(FOOT - ROUND, ROUND), ROUND, -FRAC_PI_2, lean);
    let rim_middle = DVec2::new(TOP - RIM, HEIGHT - RIM);
    // The rim ends where it is as steep as the beginning of the hollow.
    let end = PI - 0.45;
    let rim = arc(rim_middle, RIM, lean, end);
    let (start, slope) = (rim(1.0), DVec2::from_angle(end + FRAC_PI_2));
    let floor = DVec2::new(0.0, HEIGHT - HOLLOW);
    let (pull, rest) = (start + slope * 0.11, floor + DVec2::new(0.17, 0.0));
    let hollow = move |t: f64| {
        let u = 1.0 - t;
        start * (u * u * u) + pull * (3.0 * u * u * t) + rest * (3.0 * u * t * t) + floor * (t * t * t)
    };
    let bottom = move |t: f64| DVec2::new((FOOT - ROUND) * t, 0.0);
    let (low, high) = (foot(1.0), rim(0.0));
    let wall = move |t: f64| low.lerp(high, t);

    let mut outline = vec![DVec2::ZERO];
    let mut add = |curve: &dyn Fn(f64) -> DVec2, least: u32| {
        let length: f64 = (0..64).map(|k| curve(f64::from(k) / 64.0).distance(curve(f64::from(k + 1) / 64.0))).sum();
        let steps = (length / step).ceil().clamp(f64::from(least), 4096.0);
        let mut at = 1.0;
        while at <= steps {
            outline.push(curve(at / steps));
            at += 1.0;
        }
    };
    add(&bottom, 3);
    add(&foot, 6);
    add(&wall, 4);
    add(&rim, 10);
    add(&hollow, 6);
    // The last point lies exactly on the axis.
    if let Some(end) = outline.last_mut() {
        *end = floor;
    }
    outline
}
