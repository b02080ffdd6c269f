//! The sections with checks that can fail: conformance per stage, and the extreme cases.

use super::whole::verdict;
use super::{Bench, Page};
use crate::error::Result;
use crate::measure::bias::farthest;
use crate::measure::conform::conform as compare;
use crate::measure::fixtures::fixtures;
use crate::measure::leaning::{blame, of_stage};
use crate::measure::stress::{Bound, Outcome, stress as extremes};
use crate::measure::table::Table;

/// Fixtures of a quick report: those whose name contains one of these. Together they run every stage.
const FEW: [&str; 23] = [
    "one triangle",
    "sliver",
    "lights of two colours",
    "scattered once in two objects of three",
    "opaque and lit by triangle",
    "three objects, receivers at pixels",
    "three objects, two of them deformed",
    "three objects, two of them with joints",
    "three objects, links kept",
    "three objects, brute force",
    "walk through three objects",
    "diffusion in three objects",
    "bump over kept links, budget",
    "kept links of another material, budget",
    "the second of three samples, filmic",
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
    used: f64,
    faults: usize,
}

/// Compares every stage on the device with the CPU reference.
pub fn conform(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(device) = bench.device else {
        page.say("The CPU is the reference itself: there is no device to compare with it.");
        return Ok(());
    };
    page.say(
        "Each stage runs on the device and, in f64, on the CPU, from the same state. Then all memory is compared: \
         decisions bit for bit, values within the stage's tolerance; buffers that a stage does not write must not \
         change. Two runs on the device must give the same bits.",
    );
    let mut stages: Vec<Stage> = Vec::new();
    let (mut count, mut rows) = (0, Vec::new());
    for few in bench.either(&FEW[..], &[""]) {
        let found = fixtures(few)?.iter().map(|fixture| compare(device, fixture, &[])).collect::<Result<Vec<_>>>()?;
        count += found.len();
        rows.extend(found.into_iter().flatten());
    }
    blame(&mut rows);
    for row in &rows {
        for fault in &row.faults {
            page.fail(&format!("{}: {fault}", row.fixture));
        }
        if !stages.iter().any(|stage| stage.name == row.stage) {
            stages.push(Stage { name: row.stage, ..Stage::default() });
        }
        for stage in stages.iter_mut().filter(|stage| stage.name == row.stage) {
            stage.fixtures += 1;
            stage.words += row.distances.words;
            stage.ulp = stage.ulp.max(row.distances.ulp);
            stage.used = stage.used.max(row.distances.used);
            stage.faults += row.faults.len();
        }
    }
    let mean = |stage: &Stage| farthest(&of_stage(&rows, stage.name)).map_or("-".into(), |mean| format!("{mean:+.0e}"));
    page.table("conform", &conform_table(&stages, &mean))?;
    let (words, faults) =
        (stages.iter().map(|s| s.words).sum::<usize>(), stages.iter().map(|s| s.faults).sum::<usize>());
    if faults == 0 && words > 0 {
        let all = if bench.quick { "; `milkglass conform` runs them all" } else { "" };
        page.say(&format!("{} stages on {count} fixtures conform, {words} words compared{all}.", stages.len()));
    } else if words == 0 {
        page.fail("nothing was compared");
    }
    verdict(page, "Conforms", &format!("{} stages on {count} fixtures, against the CPU reference", stages.len()));
    Ok(())
}

fn conform_table(stages: &[Stage], mean: &dyn Fn(&Stage) -> String) -> Table {
    Table::of(
        stages,
        &[
            ("stage", "", &|s| s.name.into()),
            ("fixtures", "scenes made for this test in which the stage was compared", &|s| s.fixtures.to_string()),
            ("words compared", "4-byte words of the buffers that the stage writes, over all fixtures", &|s| {
                s.words.to_string()
            }),
            (
                "largest ulp",
                "largest distance of a float from the reference, in units in the last place; - above a million, which \
                 is near 0",
                // Near zero a distance in units in the last place is meaningless.
                &|s| if s.ulp > 1_000_000 { "-".into() } else { s.ulp.to_string() },
            ),
            (
                "largest, % of tolerance",
                "largest difference from the reference, in per cent of the difference that the stage's tolerance \
                 allows; 0 where only decisions are made, which must agree bit for bit",
                &|s| format!("{:.2}", 100.0 * s.used),
            ),
            (
                "mean",
                "mean of the signed relative differences over all fixtures, of the buffer that is farthest off: \
                 rounding stays below 2e-6, a systematic error does not",
                mean,
            ),
            ("verdict", "", &|s| if s.faults == 0 { "conforms" } else { "DIFFERS" }.into()),
        ],
    )
}

/// Runs the extreme cases.
pub fn stress(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(
        "Scenes and form factors at the limits of the input: whether every value is finite, and the error against f64 \
         beside its bound.",
    );
    let outcomes = extremes(bench.device, "", None)?;
    for outcome in &outcomes {
        outcome.faults.iter().for_each(|fault| page.fail(&format!("{}: {fault}", outcome.case.name)));
    }
    page.table("stress", &stress_table(&outcomes))?;
    verdict(page, "Stable", &format!("{} extreme cases, finite and within their bounds", outcomes.len()));
    Ok(())
}

/// Extreme cases with their errors, bounds and verdicts.
#[must_use]
pub fn stress_table(outcomes: &[Outcome]) -> Table {
    let number = |x: f64| format!("{x:.1e}");
    let bounds = |bound: Bound| format!("{:e} {:e}", bound.l2, bound.max);
    Table::of(
        outcomes,
        &[
            ("case", "", &|o| o.case.name.into()),
            ("finite", "whether all values are finite and at least 0", &|o| if o.sound { "yes" } else { "NO" }.into()),
            ("L2", "relative L2 error of the usual method against f64", &|o| number(o.usual.l2)),
            ("max", "its largest error, over the rms", &|o| number(o.usual.max)),
            (
                "bounds",
                "what both errors may be: about three times the largest that was measured on the devices tested",
                &|o| bounds(o.case.bound),
            ),
            ("brute L2", "the same of brute force in f32 on the device", &|o| number(o.brute.l2)),
            ("brute max", "its largest error", &|o| number(o.brute.max)),
            ("brute bounds", "what both errors may be", &|o| bounds(o.case.brute)),
            ("octree L2", "the octree's error, for information: it decides nothing", &|o| {
                o.octree.map_or("-".into(), |error| number(error.l2))
            }),
            ("verdict", "", &|o| if o.faults.is_empty() { "passes" } else { "FAILS" }.into()),
            ("documented fallback", "what the program does in this case", &|o| o.case.fallback.into()),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::frame::STAGES;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn a_quick_report_compares_every_stage() {
        let found: Vec<_> = FEW.iter().flat_map(|few| fixtures(few).unwrap()).collect();
        let compared =
            |name: &str| found.iter().any(|fixture| fixture.steps.iter().any(|step| step.stage.name == name));
        let missing: Vec<&str> = STAGES.iter().map(|stage| stage.name).filter(|name| !compared(name)).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}
