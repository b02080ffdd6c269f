//! `milkglass fit-cdrf`: fits the sigma_0 of a material.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, print, table, validation};
use milkglass::error::{Input, Result};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::lighting::fresnel;
use milkglass::internals::shading::balls::fit::{Fit, fit};
use milkglass::internals::shading::balls::usual::spread;
use milkglass::internals::shading::balls::{ANGLES, Curve, angle, dipole::curve as solve, radii};
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::balls::plot::{Panel, svg};
use milkglass::measure::balls::walk::curves as walk;
use milkglass::measure::bodies::{Medium, Walks};
use milkglass::scene::{MOST_WALKS, Preset};

/// Arguments of `fit-cdrf`.
#[derive(Args)]
#[command(after_help = "Example: milkglass fit-cdrf skin1 --svg skin1.svg")]
pub struct Arguments {
    /// A preset; `milkglass materials` lists them.
    material: String,
    #[command(flatten)]
    device: DeviceArgument,
    /// Radii of the balls, mm [default: 2, 5, 10, 20, 50 and 100 mean free paths, averaged over the channels; within a
    /// factor of 4 of the channel's own].
    #[arg(long, value_name = "R,R,...")]
    radii: Option<String>,
    /// Photons of each ball's random walk, and channel.
    #[arg(long, default_value_t = 30_000)]
    photons: u64,
    /// Seed of the random walks.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw the curves to this file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// Most radii, and most photons per ball.
const MOST: (usize, u64) = (64, MOST_WALKS as u64);

/// One channel's balls.
struct Channel {
    dipole: Vec<Curve>,
    walk: Vec<Curve>,
    /// Where the search starts.
    spread: f64,
}

/// Fits and prints.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--svg", arguments.svg.as_ref())])?;
    let preset = Preset::named(&arguments.material).ok_or_else(|| {
        let fault = Input::new("no material of this name is built in").key("MATERIAL").found(&arguments.material);
        fault.expected("one of `milkglass materials`")
    })?;
    if !(1..=MOST.1).contains(&arguments.photons) {
        let fault = Input::new("out of range").key("--photons").found(arguments.photons);
        return Err(fault.expected(format!("1 to {}", MOST.1)).into());
    }
    let paths = [0, 1, 2].map(|c| 1.0 / (preset.sigma_s_prime[c] + preset.sigma_a[c]));
    let given = arguments.radii.as_deref().map(parse).transpose()?;
    let inner = fresnel::diffuse_internal_exact(preset.eta);
    let media = Medium::of(preset);
    let dipoles = media.map(|medium| Dipole::new(medium.scattering, medium.absorption, fresnel::boundary(inner)));
    let radii = [0, 1, 2].map(|c| given.clone().unwrap_or_else(|| radii(paths, c).to_vec()));
    let mut channels = [0, 1, 2].map(|c| Channel {
        dipole: radii[c].iter().map(|&radius| solve(&dipoles[c], radius)).collect(),
        walk: Vec::new(),
        spread: spread(&dipoles[c]),
    });
    let device = arguments.device.open(validation())?;
    for (k, ((&red, &green), &blue)) in radii[0].iter().zip(&radii[1]).zip(&radii[2]).enumerate() {
        let seed = arguments.seed.wrapping_mul(1000).wrapping_add(k as u64);
        let walks = Walks { device: device.as_ref(), media, photons: arguments.photons, seed };
        let balls = walk(&walks, [red, green, blue], dipoles.each_ref().map(Dipole::total))?;
        channels.iter_mut().zip(balls).for_each(|(channel, ball)| channel.walk.push(ball));
    }
    report(preset, &channels)?;
    if let Some(path) = &arguments.svg {
        let fits = channels.each_ref().map(|channel| fit(&channel.dipole, channel.spread, false).sigma_0);
        let panels: Vec<_> = (0..3)
            .map(|c| Panel { name: NAMES[c], dipole: &channels[c].dipole, walk: &channels[c].walk, sigma_0: fits[c] })
            .collect();
        let title =
            format!("{}: balls in parallel light; lines: the CDRF, dots: the dipole, bars: a random walk", preset.name);
        let picture = svg(&title, &panels)?;
        write_atomically(path, |beside| std::fs::write(beside, picture).map_err(|e| e.to_string()))?;
    }
    Ok(())
}

const NAMES: [&str; 3] = ["red", "green", "blue"];

/// Prints the fits of all radii together, then of each radius.
fn report(preset: &Preset, channels: &[Channel; 3]) -> Result<()> {
    let cells =
        |found: Fit| [format!("{:.4}", found.sigma_0), format!("{:.4}", found.residual), format!("{:.3}", found.worst)];
    // Weighted as in the residual.
    let error = |curves: &[Curve]| {
        let part = |(k, error): (usize, &f64)| [angle(k).sin() * error * error, angle(k).sin()];
        let all = curves.iter().flat_map(|curve| curve.errors.iter().enumerate().map(part));
        let [squares, whole] = all.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        format!("{:.4}", f64::sqrt(squares / whole))
    };
    let mut rows = Vec::new();
    let (mut dipole_fit, mut walk_fit) = ([0.0; 3], [0.0; 3]);
    for (c, channel) in channels.iter().enumerate() {
        let all = [(&channel.dipole, false), (&channel.walk, true)];
        let all = all.map(|(curves, free)| fit(curves, channel.spread, free));
        (dipole_fit[c], walk_fit[c]) = (all[0].sigma_0, all[1].sigma_0);
        let row = |radius: String, fits: [Fit; 2], walk: &[Curve]| {
            let mut row = vec![NAMES[c].to_string(), radius];
            row.extend(fits.iter().copied().flat_map(cells));
            row.extend([format!("{:.3}", fits[1].scale), error(walk)]);
            row
        };
        rows.push(row("all".into(), all, &channel.walk));
        for (dipole, walk) in channel.dipole.iter().zip(&channel.walk) {
            let own = [(dipole, false), (walk, true)];
            let own = own.map(|(curve, free)| fit(std::slice::from_ref(curve), channel.spread, free));
            rows.push(row(format!("{:.3}", dipole.radius), own, std::slice::from_ref(walk)));
        }
    }
    let header = [
        "channel",
        "radius, mm",
        "dipole: sigma_0",
        "residual",
        "worst",
        "walk: sigma_0",
        "residual",
        "worst",
        "times",
        "its error",
    ];
    let list = |values: [f64; 3]| values.map(|x| format!("{x:.4}")).join(", ");
    let text = format!(
        "{}: residuals are root mean squares over a ball, at {} angles, of what leaves a plane in full light; \
         the walk is fitted by f times a number, since the dipole is off by some in a plane already\n\n{}\n\
         fitted to the dipole:      sigma_0 = [{}]\nfitted to the random walk: sigma_0 = [{}]\n\
         without material.sigma_0:  sigma_0 = [{}]\n",
        preset.name,
        ANGLES,
        table(&header, &[1, 2, 3, 4, 5, 6, 7, 8, 9], &rows),
        list(dipole_fit),
        list(walk_fit),
        list(preset.sigma_0),
    );
    print(&text)
}

/// Parses `1,5,20`, mm.
fn parse(text: &str) -> Result<Vec<f64>> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|r| (1e-6..=1e6).contains(r));
    let radii: Option<Vec<f64>> = text.split(',').map(number).collect();
    radii.filter(|radii| radii.len() <= MOST.0).ok_or_else(|| {
        let fault = Input::new("no radii").key("--radii").found(text);
        fault.expected(format!("up to {} numbers from 1e-6 to 1e6, mm: 1,5,20", MOST.0)).into()
    })
}
