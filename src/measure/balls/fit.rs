//! sigma_0 of a preset, fitted to balls of several radii, and the plot of the fit.

use crate::dipole::profile::Dipole;
use crate::error::Result;
use crate::gpu::Device;
use crate::lighting::fresnel;
use crate::measure::balls::walk::curves as walk;
use crate::measure::bodies::{Medium, Walks};
use crate::measure::plot::{Axis, Mark, Panel, Plot, Point, SIZE, Series, hue};
use crate::scene::Preset;
use crate::shading::balls::fit::{Fit, fit};
use crate::shading::balls::usual::spread;
use crate::shading::balls::{ANGLES, Curve, angle, dipole::curve as solve, radii};
use crate::shading::reflectance::cdrf;

/// The balls of one channel.
pub struct Channel {
    /// Red, green or blue.
    pub name: &'static str,
    /// The dipole's curves, one per radius.
    pub dipole: Vec<Curve>,
    /// The random walk's curves, one per radius.
    pub walk: Vec<Curve>,
    /// Where the search for sigma_0 starts.
    spread: f64,
}

impl Channel {
    /// The fits to these curves of the dipole and of the walk; the latter times a number, since the dipole is off by
    /// some in a plane already.
    #[must_use]
    pub fn fits(&self, [dipole, walk]: [&[Curve]; 2]) -> [Fit; 2] {
        [(dipole, false), (walk, true)].map(|(curves, free)| fit(curves, self.spread, free))
    }

    /// The fits to all radii together.
    #[must_use]
    pub fn fit(&self) -> [Fit; 2] {
        self.fits([&self.dipole, &self.walk])
    }
}

/// Balls of a preset, by the dipole and by walks of `photons` photons a ball and channel, on a device or the CPU. Their
/// radii are those `given`, mm, or else the usual ones of each channel.
pub fn channels(
    preset: &Preset,
    device: Option<&Device>,
    given: Option<&[f64]>,
    (photons, seed): (u64, u64),
) -> Result<[Channel; 3]> {
    let paths = [0, 1, 2].map(|c| 1.0 / (preset.sigma_s_prime[c] + preset.sigma_a[c]));
    let radii = [0, 1, 2].map(|c| given.map_or_else(|| radii(paths, c).to_vec(), <[f64]>::to_vec));
    let boundary = fresnel::boundary(fresnel::diffuse_internal_exact(preset.eta));
    let media = Medium::of(preset);
    let dipoles = media.map(|medium| Dipole::new(medium.scattering, medium.absorption, boundary));
    let mut channels = [(0, "red"), (1, "green"), (2, "blue")].map(|(c, name)| Channel {
        name,
        dipole: radii[c].iter().map(|&radius| solve(&dipoles[c], radius)).collect(),
        walk: Vec::new(),
        spread: spread(&dipoles[c]),
    });
    for k in 0..radii[0].len() {
        let walks = Walks { device, media, photons, seed: seed.wrapping_mul(1000).wrapping_add(k as u64) };
        let balls = walk(&walks, radii.each_ref().map(|radii| radii[k]), dipoles.each_ref().map(Dipole::total))?;
        channels.iter_mut().zip(balls).for_each(|(channel, ball)| channel.walk.push(ball));
    }
    Ok(channels)
}

/// Draws exitant light over the angle, a panel a channel: lines are f at the sigma_0 fitted to the dipole, dots the
/// dipole, bars the random walk with twice its standard error.
pub fn svg(title: &str, channels: &[Channel]) -> Result<String> {
    let panels = channels.iter().map(panel).collect();
    Plot { title: vec![title.into()], panels, columns: channels.len(), shared: false }.svg()
}

fn panel(channel: &Channel) -> Panel {
    let [Fit { sigma_0, .. }, _] = channel.fit();
    let most = channel.dipole.iter().chain(&channel.walk).flat_map(|curve| &curve.values);
    // Few photons leave far from the light: the noisy values there may lie outside the plot.
    let top = 1.05 * most.fold(1.0, |a: f64, &b| a.max(b.min(1.2)));
    let degree = |k: usize| angle(k).to_degrees();
    let mut series = Vec::new();
    for (number, (curve, walk)) in channel.dipole.iter().zip(&channel.walk).enumerate() {
        let color = hue(1.0 - number as f64 / channel.dipole.len() as f64);
        let line = (0..=180).map(f64::from);
        let line = line.map(|degree| (degree, cdrf(degree.to_radians().cos(), sigma_0 / curve.radius)));
        series.push(Series::line(format!("radius {:.3} mm", curve.radius), line).colored(color));
        series.push(Series::dots("", (0..ANGLES).map(|k| (degree(k), curve.values[k]))).colored(color));
        let bar = |k: usize| {
            let (value, error) = (walk.values[k], 2.0 * walk.errors[k]);
            let ends = [value - error, value + error].map(|value| [degree(k), value]);
            Point { place: [degree(k), value], ends: Some(ends), ..Point::default() }
        };
        let bars = Series { points: (0..ANGLES).map(bar).collect(), ..Series::new("", Mark::Bars, []) };
        series.push(bars.colored(color));
    }
    let axes = [
        Axis::linear("angle from the light, degrees").within([0.0, 180.0]),
        Axis::linear("light that leaves, of a plane's").within([0.0, top]),
    ];
    let title = format!("{}: sigma_0 = {sigma_0:.3} mm", channel.name);
    Panel { size: [SIZE[0], SIZE[1] + 60], ..Panel::new(title, axes, series) }
}
