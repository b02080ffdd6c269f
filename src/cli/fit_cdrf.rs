//! `milkglass fit-cdrf`: fits the sigma_0 of a material.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, print, validation, write};
use milkglass::error::{Input, Result};
use milkglass::internals::shading::balls::fit::Fit;
use milkglass::internals::shading::balls::{ANGLES, Curve, angle};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::balls::fit::{Channel, channels, svg};
use milkglass::measure::table::Table;
use milkglass::scene::{MOST_WALKS, Preset};

/// Arguments of `fit-cdrf`.
#[derive(Args)]
#[command(after_help = "Example: milkglass fit-cdrf skin1 --svg skin1.svg")]
pub struct Arguments {
    /// A preset; `milkglass materials` lists them.
    material: String,
    #[command(flatten)]
    device: DeviceArgument,
    /// Radii of the balls, mm [default: 2, 5, 10, 20, 50 and 100 mean free paths, averaged over the channels but at
    /// most 4 times longer or shorter than the channel's own].
    #[arg(long, value_name = "R,R,...")]
    radii: Option<String>,
    /// Photons of the random walk in each ball and channel.
    #[arg(long, default_value_t = 30_000)]
    photons: u64,
    /// Seed of the random walks.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Draw the curves to this file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// Most radii, and most photons per ball and channel.
const MOST: (usize, u64) = (64, MOST_WALKS as u64);

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
    let given = arguments.radii.as_deref().map(parse).transpose()?;
    let device = arguments.device.open(validation())?;
    let effort = (arguments.photons, arguments.seed);
    let channels = channels(preset, device.as_ref(), given.as_deref(), effort)?;
    report(preset, &channels)?;
    let Some(path) = &arguments.svg else { return Ok(()) };
    let title =
        format!("{}: balls in parallel light; lines: the CDRF, dots: the dipole, bars: a random walk", preset.name);
    write(path, svg(&title, &channels)?)
}

/// Prints the fits of all radii together, then of each radius.
fn report(preset: &Preset, channels: &[Channel; 3]) -> Result<()> {
    // Weighted as in the residual.
    let error = |curves: &[Curve]| {
        let part = |(k, error): (usize, &f64)| [angle(k).sin() * error * error, angle(k).sin()];
        let all = curves.iter().flat_map(|curve| curve.errors.iter().enumerate().map(part));
        let [squares, whole] = all.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        format!("{:.4}", f64::sqrt(squares / whole))
    };
    let mut rows: Vec<(&str, String, [Fit; 2], &[Curve])> = Vec::new();
    for channel in channels {
        rows.push((channel.name, "all".into(), channel.fit(), &channel.walk));
        for (dipole, walk) in channel.dipole.iter().zip(channel.walk.chunks(1)) {
            let fits = channel.fits([std::slice::from_ref(dipole), walk]);
            rows.push((channel.name, format!("{:.3}", dipole.radius), fits, walk));
        }
    }
    let digits = |x: f64| format!("{x:.4}");
    let table = Table::of(
        &rows,
        &[
            ("channel", "", &|row| row.0.into()),
            ("radius, mm", "", &|row| row.1.clone()),
            ("dipole: sigma_0", "", &|row| digits(row.2[0].sigma_0)),
            ("residual", "", &|row| digits(row.2[0].residual)),
            ("worst", "", &|row| format!("{:.3}", row.2[0].worst)),
            ("walk: sigma_0", "", &|row| digits(row.2[1].sigma_0)),
            ("residual", "", &|row| digits(row.2[1].residual)),
            ("worst", "", &|row| format!("{:.3}", row.2[1].worst)),
            ("times", "", &|row| format!("{:.3}", row.2[1].scale)),
            ("its error", "", &|row| error(row.3)),
        ],
    );
    let list = |values: [f64; 3]| values.map(digits).join(", ");
    let fitted = |k: usize| list(channels.each_ref().map(|channel| channel.fit()[k].sigma_0));
    print(&format!(
        "{}: residuals are root mean squares over a ball, at {} angles, of what leaves a plane in full light; \
         the walk is fitted by f times a number, since the dipole is off by some in a plane already\n\n{}\n\
         fitted to the dipole:      sigma_0 = [{}]\nfitted to the random walk: sigma_0 = [{}]\n\
         without material.sigma_0:  sigma_0 = [{}]\n",
        preset.name,
        ANGLES,
        table.text(),
        fitted(0),
        fitted(1),
        list(preset.sigma_0),
    ))
}

/// Parses `1,5,20`, mm.
fn parse(text: &str) -> Result<Vec<f64>> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|r| (1e-6..=1e6).contains(r));
    let radii: Option<Vec<f64>> = text.split(',').map(number).collect();
    radii.filter(|radii| radii.len() <= MOST.0).ok_or_else(|| {
        let fault = Input::new("not a list of radii").key("--radii").found(text);
        fault.expected(format!("up to {} numbers from 1e-6 to 1e6, mm: 1,5,20", MOST.0)).into()
    })
}
