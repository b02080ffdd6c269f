//! `milkglass stress`: runs the table of extreme cases.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, check_messages, print, table, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::stress::{Bound, Outcome, Worst, stress};

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

/// Runs the cases, prints the table, and fails if one of them does.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--csv", arguments.csv.as_ref())])?;
    let device = arguments.device.open(validation())?;
    let outcomes = stress(device.as_ref(), &arguments.only, None)?;
    check_messages(device.as_ref())?;
    let rows: Vec<_> = outcomes.iter().map(row).collect();
    let header = [
        "case",
        "finite",
        "L2",
        "max",
        "bounds",
        "brute L2",
        "max",
        "bounds",
        "octree L2",
        "verdict",
        "documented fallback",
    ];
    print(&table(&header, &[2, 3, 5, 6, 8], &rows))?;
    if let Some(path) = &arguments.csv {
        let text = csv(&outcomes).map_err(|e| Input::new(e).file(path))?;
        write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))?;
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

fn finite(outcome: &Outcome) -> String {
    if outcome.sound { "yes" } else { "NO" }.to_string()
}

fn verdict(outcome: &Outcome) -> String {
    if outcome.faults.is_empty() { "passes" } else { "FAILS" }.to_string()
}

fn row(outcome: &Outcome) -> Vec<String> {
    let case = outcome.case;
    let errors = |error: Worst, bound: Bound| {
        [format!("{:.1e}", error.l2), format!("{:.1e}", error.max), format!("{:e} {:e}", bound.l2, bound.max)]
    };
    let mut cells = vec![case.name.to_string(), finite(outcome)];
    cells.extend(errors(outcome.usual, case.bound));
    cells.extend(errors(outcome.brute, case.brute));
    let octree = outcome.octree.map_or("-".to_string(), |error| format!("{:.1e}", error.l2));
    cells.extend([octree, verdict(outcome), case.fallback.to_string()]);
    cells
}

fn csv(outcomes: &[Outcome]) -> std::result::Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let errors = ["l2", "max", "bound_l2", "bound_max", "brute_l2", "brute_max", "brute_bound_l2", "brute_bound_max"];
    let header =
        ["case", "finite"].iter().chain(&errors).chain(&["verdict", "fallback", "reason", "octree_l2", "octree_max"]);
    writer.write_record(header).map_err(|e| e.to_string())?;
    for outcome in outcomes {
        let case = outcome.case;
        let (usual, brute) = (outcome.usual, outcome.brute);
        let numbers = [usual.l2, usual.max, case.bound.l2, case.bound.max, brute.l2, brute.max]
            .into_iter()
            .chain([case.brute.l2, case.brute.max])
            .map(|x| format!("{x:e}"));
        let before = [case.name.to_string(), finite(outcome)];
        // Blank where there is no octree result.
        let octree = outcome.octree.map_or([const { String::new() }; 2], |e| [e.l2, e.max].map(|x| format!("{x:e}")));
        let after = [verdict(outcome), case.fallback.to_string(), case.reason.to_string()].into_iter().chain(octree);
        writer.write_record(before.into_iter().chain(numbers).chain(after)).map_err(|e| e.to_string())?;
    }
    writer.into_inner().map_err(|e| e.to_string())
}
