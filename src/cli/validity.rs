//! `milkglass validity`: shows where shading by curvature is a good approximation of the dipole, and where it is not.

use std::path::{Path, PathBuf};

use clap::Args;
use plotters::prelude::*;

use super::device::DeviceArgument;
use super::{SceneArguments, check_messages, print, table, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::validity::{BENT, Place, Share, THICK, lambert_share, places, share, verdict};

/// Arguments of `validity`.
#[derive(Args)]
#[command(after_help = "Example: milkglass validity bust --svg bust.svg")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    device: DeviceArgument,
    /// Plot error against thickness in this file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Also write this CSV file, a row per triangle and channel: sigma, thickness over sigma_0, and the radiosities by
    /// the dipole, the CDRF and Lambert's cosine.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// Compares and prints the result.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--csv", arguments.csv.as_ref()), ("--svg", arguments.svg.as_ref())])?;
    let scene = arguments.scene.load()?;
    let device = arguments.device.open(validation())?;
    let all = places(&scene, device.as_ref())?;
    check_messages(device.as_ref())?;
    if all.is_empty() {
        return Err(Input::new("no light enters any object").expected("an object that is not opaque").into());
    }

    // Rows by thickness, columns by sigma.
    let edges = |inner: &[f64]| [&[0.0], inner, &[f64::INFINITY]].concat();
    let (thick, bent) = (edges(&THICK), edges(&BENT));
    let within = |x: f64, pair: &[f64]| x >= pair[0] && (x < pair[1] || pair[1].is_infinite());
    let span = |pair: &[f64]| match pair[1].is_infinite() {
        true => format!("from {}", pair[0]),
        false => format!("{} to {}", pair[0], pair[1]),
    };
    let cell = |part: Share| match part.area > 0.0 {
        true => format!("{:.0} % ({:.0} %)", 100.0 * part.error, 100.0 * part.area),
        false => "-".into(),
    };
    let percent = |part: Share| if part.area > 0.0 { format!("{:.0} %", 100.0 * part.error) } else { "-".into() };
    let row = |pair: &[f64]| {
        let mut cells = vec![span(pair)];
        let both = |own: &[f64]| cell(share(&all, |p| within(p.thickness, pair) && within(p.sigma, own)));
        cells.extend(bent.windows(2).map(both));
        cells.push(cell(share(&all, |p| within(p.thickness, pair))));
        cells.push(percent(lambert_share(&all, |p| within(p.thickness, pair))));
        cells
    };
    let rows: Vec<_> = thick.windows(2).map(row).collect();
    let heads: Vec<String> = bent.windows(2).map(|pair| format!("sigma {}", span(pair))).collect();
    let header: Vec<&str> =
        ["thickness / sigma_0"].into_iter().chain(heads.iter().map(String::as_str)).chain(["all", "Lambert"]).collect();
    print(&format!(
        "error of the CDRF against the dipole, L2 of the part (its share of the surface); last, of Lambert's cosine\n\n\
         {}\nall: {}; Lambert: {}\n{}\n",
        table(&header, &[], &rows),
        cell(share(&all, |_| true)),
        percent(lambert_share(&all, |_| true)),
        verdict(&all)
    ))?;
    if let Some(path) = &arguments.csv {
        write_csv(&all, path)?;
    }
    if let Some(path) = &arguments.svg {
        let mut picture = String::new();
        draw(&mut picture, &scene.name, &all).map_err(|e| Error::Check(format!("the plot could not be drawn: {e}")))?;
        write_atomically(path, |beside| std::fs::write(beside, picture).map_err(|e| e.to_string()))?;
    }
    Ok(())
}

fn write_csv(all: &[Place], path: &Path) -> Result<()> {
    let mut text =
        String::from("object,triangle,channel,area,sigma,thickness_over_sigma_0,B_dipole,B_cdrf,B_lambert\n");
    for p in all {
        let Place { object, triangle, channel, area, sigma, thickness, dipole, cdrf, lambert } = p;
        text += &format!(
            "{object},{triangle},{channel},{area:e},{sigma:e},{thickness:e},{dipole:e},{cdrf:e},{lambert:e}\n"
        );
    }
    write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))
}

/// Most dots of the plot.
const DOTS: usize = 6000;

/// Plots error against thickness, one dot per triangle and channel, coloured by sigma: blue 0, red 1 and more.
fn draw(picture: &mut String, name: &str, all: &[Place]) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(picture, (760, 520)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(format!("{name}: CDRF / dipole - 1, by thickness; blue to red: sigma 0 to 1"), ("sans-serif", 16))
        .margin(10)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d((0.1..100.0).log_scale(), -1.0..2.0)?;
    chart
        .configure_mesh()
        .x_desc("thickness / sigma_0")
        .y_desc("error, share of the dipole's radiosity")
        .light_line_style(WHITE)
        .draw()?;
    let every = all.len().div_ceil(DOTS).max(1);
    let dot = |p: &Place| {
        let error = ((p.cdrf - p.dipole) / p.dipole).clamp(-1.0, 2.0);
        let color = HSLColor(0.66 * (1.0 - p.sigma.min(1.0)), 0.8, 0.45);
        (p.dipole > 0.0).then(|| Circle::new((p.thickness.clamp(0.1, 100.0), error), 1, color.filled()))
    };
    chart.draw_series(all.iter().step_by(every).filter_map(dot))?;
    root.present()?;
    Ok(())
}
