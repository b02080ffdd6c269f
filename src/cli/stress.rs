//! `milkglass stress`: runs the table of extreme cases.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, check_messages, print, validation, write};
use milkglass::error::{Error, Result};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::report::stress_table;
use milkglass::measure::stress::{Outcome, Worst, stress};
use milkglass::measure::table::{Column, Table};

/// Arguments of `stress`.
#[derive(Args)]
#[command(
    after_help = "Example: milkglass stress --csv stress.csv\n         milkglass stress --only sliver --device cpu"
)]
pub struct Arguments {
    #[command(flatten)]
    device: DeviceArgument,
    /// Only cases whose name contains this.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// Also write the table to this file, with the reasons for the bounds.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// Runs the cases, prints the table, and fails if one of the cases fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--csv", arguments.csv.as_ref())])?;
    let device = arguments.device.open(validation())?;
    let outcomes = stress(device.as_ref(), &arguments.only, None)?;
    check_messages(device.as_ref())?;
    print(&stress_table(&outcomes).text())?;
    if let Some(path) = &arguments.csv {
        write(path, csv(&outcomes)?)?;
    }
    for outcome in &outcomes {
        for fault in &outcome.faults {
            tell!("{}: {fault}", outcome.case.name);
        }
    }
    let failed = outcomes.iter().filter(|outcome| !outcome.faults.is_empty()).count();
    if failed > 0 {
        return Err(Error::Check(format!("{failed} of {} cases fail", outcomes.len())));
    }
    print(&format!("{} cases, all pass\n", outcomes.len()))
}

/// The table as a file, with the reasons for the bounds.
fn csv(outcomes: &[Outcome]) -> Result<String> {
    let octree = |outcome: &Outcome, norm: fn(Worst) -> f64| {
        // Blank where there is no octree result.
        outcome.octree.map_or_else(String::new, |error| format!("{:e}", norm(error)))
    };
    let columns: [Column<'_, Outcome>; 15] = [
        ("case", "", &|o| o.case.name.into()),
        ("finite", "", &|o| if o.sound { "yes" } else { "NO" }.into()),
        ("l2", "", &|o| format!("{:e}", o.usual.l2)),
        ("max", "", &|o| format!("{:e}", o.usual.max)),
        ("bound_l2", "", &|o| format!("{:e}", o.case.bound.l2)),
        ("bound_max", "", &|o| format!("{:e}", o.case.bound.max)),
        ("brute_l2", "", &|o| format!("{:e}", o.brute.l2)),
        ("brute_max", "", &|o| format!("{:e}", o.brute.max)),
        ("brute_bound_l2", "", &|o| format!("{:e}", o.case.brute.l2)),
        ("brute_bound_max", "", &|o| format!("{:e}", o.case.brute.max)),
        ("verdict", "", &|o| if o.faults.is_empty() { "passes" } else { "FAILS" }.into()),
        ("fallback", "", &|o| o.case.fallback.into()),
        ("reason", "", &|o| o.case.reason.into()),
        ("octree_l2", "", &|o| octree(o, |error| error.l2)),
        ("octree_max", "", &|o| octree(o, |error| error.max)),
    ];
    Table::of(outcomes, &columns).csv()
}
