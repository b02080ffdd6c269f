//! The sections with checks that can fail: conformance per stage, and the extreme cases.

use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::conform::conform as compare;
use crate::measure::fixtures::fixtures;
use crate::measure::stress::{Outcome, stress as extremes};

/// Fixtures of a quick report: those whose name contains one of these. Together they run every stage.
const FEW: [&str; 17] = [
    "one triangle",
    "sliver",
    "lights of two colours",
    "opaque and lit by triangle",
    "three objects, receivers at pixels",
    "three objects, two of them deformed",
    "three objects, links kept",
    "three objects, brute force",
    "bump over kept links, budget",
    "layers of two objects",
    "cdrf from a table",
    "cdrf, single values",
    "lambert of three objects",
    "texture blur of pieces that lie apart",
    "reflection, GGX, environment",
    "texture at both, mirrored",
    "single form factors",
];

/// The results of one stage over all fixtures.
#[derive(Default)]
struct Stage {
    name: &'static str,
    fixtures: usize,
    words: usize,
    ulp: u64,
    relative: f64,
    faults: usize,
}

/// Compares every stage on the device with the CPU reference.
pub fn conform(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(device) = bench.device else {
        page.say("The CPU is the reference itself: there is no device to compare with it.");
        return Ok(());
    };
    page.say(
        "Each stage runs on the device and, as f64 Rust, on the CPU, from the same state; then all memory is compared: what \
         decides bit for bit, values within the stage's tolerance, and what is not written must not change. Two runs of the \
         device must give the same bits.",
    );
    let mut stages: Vec<Stage> = Vec::new();
    let mut count = 0;
    for few in bench.either(&FEW[..], &[""]) {
        let found = fixtures(few)?.iter().map(|fixture| compare(device, fixture, &[])).collect::<Result<Vec<_>>>()?;
        count += found.len();
        for row in found.into_iter().flatten() {
            for fault in &row.faults {
                page.fail(&format!("{}: {fault}", row.fixture));
            }
            if !stages.iter().any(|stage| stage.name == row.stage) {
                stages.push(Stage { name: row.stage, ..Stage::default() });
            }
            for stage in stages.iter_mut().filter(|stage| stage.name == row.stage) {
                stage.fixtures += 1;
                stage.words += row.words;
                stage.ulp = stage.ulp.max(row.ulp);
                stage.relative = stage.relative.max(row.relative);
                stage.faults += row.faults.len();
            }
        }
    }
    let row = |stage: &Stage| {
        // Near zero a distance in units in the last place is meaningless.
        let ulp = if stage.ulp > 1_000_000 { "-".to_string() } else { stage.ulp.to_string() };
        let verdict = if stage.faults == 0 { "conforms" } else { "DIFFERS" };
        let relative = format!("{:.1e}", stage.relative);
        vec![stage.name.into(), stage.fixtures.to_string(), stage.words.to_string(), ulp, relative, verdict.into()]
    };
    let header = ["stage", "fixtures", "words compared", "worst ulp", "worst relative", "verdict"];
    page.table("conform", &header, &stages.iter().map(row).collect::<Vec<_>>())?;
    let (words, faults) =
        (stages.iter().map(|s| s.words).sum::<usize>(), stages.iter().map(|s| s.faults).sum::<usize>());
    if faults == 0 && words > 0 {
        let all = if bench.quick { "; `milkglass conform` runs them all" } else { "" };
        page.find(
            Tone::Win,
            &format!("{} stages on {count} fixtures conform, {words} words compared{all}", stages.len()),
        );
    } else if words == 0 {
        page.fail("nothing was compared");
    }
    Ok(())
}

/// The extreme cases.
pub fn stress(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(
        "Scenes and form factors at the edge of what there is: what the program does, whether every value is a number, and \
         the error against f64 beside its bound.",
    );
    let outcomes = extremes(bench.device, "", None)?;
    for outcome in &outcomes {
        outcome.faults.iter().for_each(|fault| page.fail(&format!("{}: {fault}", outcome.case.name)));
    }
    let row = |outcome: &Outcome| {
        let case = outcome.case;
        let mut cells = vec![case.name.to_string(), if outcome.sound { "yes" } else { "NO" }.into()];
        for (error, bound) in [(outcome.usual, case.bound), (outcome.brute, case.brute)] {
            cells.extend([error.l2, error.max].map(|x| format!("{x:.1e}")));
            cells.push(format!("{:e} {:e}", bound.l2, bound.max));
        }
        cells.push(outcome.octree.map_or("-".into(), |error| format!("{:.1e}", error.l2)));
        cells.push(if outcome.faults.is_empty() { "passes" } else { "FAILS" }.into());
        cells.push(case.fallback.into());
        cells
    };
    let header = [
        "case",
        "finite",
        "L2",
        "max",
        "bounds",
        "brute L2",
        "brute max",
        "brute bounds",
        "octree L2",
        "verdict",
        "documented fallback",
    ];
    page.table("stress", &header, &outcomes.iter().map(row).collect::<Vec<_>>())?;
    let failed = outcomes.iter().filter(|outcome| !outcome.faults.is_empty()).count();
    if failed == 0 {
        page.find(Tone::Win, &format!("{} extreme cases: all finite and within their bounds", outcomes.len()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::frame::STAGES;

    #[test]
    fn a_quick_report_compares_every_stage() {
        let found: Vec<_> = FEW.iter().flat_map(|few| fixtures(few).unwrap()).collect();
        let compared =
            |name: &str| found.iter().any(|fixture| fixture.steps.iter().any(|step| step.stage.name == name));
        let missing: Vec<&str> = STAGES.iter().map(|stage| stage.name).filter(|name| !compared(name)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}
