//! `milkglass validity`: shows where shading by curvature is a good approximation of the dipole, and where it is not.

use std::path::PathBuf;

use clap::Args;

use super::device::DeviceArgument;
use super::{SceneArguments, check_messages, print, validation, write};
use milkglass::error::{Input, Result};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::table::{Column, Table};
use milkglass::measure::validity::{
    BENT, Place, Share, THICK, lambert_share, parts, places, share, span, svg, verdict,
};

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

    print(&format!(
        "error of the CDRF against the dipole, L2 of the part (its share of the surface); last, of Lambert's cosine\n\n\
         {}\nall: {}; Lambert: {}\n{}\n",
        by_thickness(&all).text(),
        cell(share(&all, |_| true)),
        percent(lambert_share(&all, |_| true)),
        verdict(&all)
    ))?;
    if let Some(path) = &arguments.csv {
        write(path, csv(&all)?)?;
    }
    arguments.svg.as_ref().map_or(Ok(()), |path| write(path, svg(&scene.name, &all)?))
}

fn percent(part: Share) -> String {
    if part.area > 0.0 { format!("{:.0} %", 100.0 * part.error) } else { "-".into() }
}

/// The error, and the share of the surface.
fn cell(part: Share) -> String {
    if part.area > 0.0 { format!("{} ({:.0} %)", percent(part), 100.0 * part.area) } else { "-".into() }
}

/// Errors of the CDRF: a row for each part of the thickness, a column for each part of sigma.
fn by_thickness(all: &[Place]) -> Table {
    let within = |x: f64, [low, high]: [f64; 2]| x >= low && (x < high || high.is_infinite());
    let (thick, bent) = (parts(&THICK), parts(&BENT));
    let row = |own: &[f64; 2]| {
        let both = |sigma: &[f64; 2]| cell(share(all, |p| within(p.thickness, *own) && within(p.sigma, *sigma)));
        let whole = cell(share(all, |p| within(p.thickness, *own)));
        let lambert = percent(lambert_share(all, |p| within(p.thickness, *own)));
        [span(own)].into_iter().chain(bent.iter().map(both)).chain([whole, lambert]).collect()
    };
    let heads: Vec<String> = bent.iter().map(|part| format!("sigma {}", span(part))).collect();
    let heads = ["thickness / sigma_0"].into_iter().chain(heads.iter().map(String::as_str)).chain(["all", "Lambert"]);
    Table::plain(heads, thick.iter().map(row).collect())
}

fn csv(all: &[Place]) -> Result<String> {
    let columns: [Column<'_, Place>; 9] = [
        ("object", "", &|p| p.object.to_string()),
        ("triangle", "", &|p| p.triangle.to_string()),
        ("channel", "", &|p| p.channel.to_string()),
        ("area", "", &|p| format!("{:e}", p.area)),
        ("sigma", "", &|p| format!("{:e}", p.sigma)),
        ("thickness_over_sigma_0", "", &|p| format!("{:e}", p.thickness)),
        ("B_dipole", "", &|p| format!("{:e}", p.dipole)),
        ("B_cdrf", "", &|p| format!("{:e}", p.cdrf)),
        ("B_lambert", "", &|p| format!("{:e}", p.lambert)),
    ];
    Table::of(all, &columns).csv()
}
