//! The section on how the Vulkan API is used.

use super::{Bench, Page};
use crate::error::Result;
use crate::gpu::AXES;
use crate::measure::profile::Settings;
use crate::measure::table::Table;
use crate::measure::vary::{Outcome, Subject, Tried, asked, strips};
use crate::scene::Scene;

/// The axes of a quick report.
const QUICK: &[&str] = &["descriptors", "barriers"];

/// Times each variant against the default.
pub fn vary(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(device) = bench.device else {
        page.say("The CPU has no API to vary.");
        return Ok(());
    };
    let sets = ["object.0.detail=3".to_string(), "camera.size=[128, 128]".into()];
    let scene = Scene::load_with("sphere", &sets)?;
    let settings = Settings { frames: bench.either(48, 128), enough: bench.either(10.0, 60.0), ..Settings::default() };
    let subject = Subject::new(&scene, device, &settings)?;
    let chosen = AXES.iter().filter(|axis| !bench.quick || QUICK.contains(&axis.name));
    let outcomes =
        chosen.map(|axis| subject.vary(asked(axis.name)?, &mut |_, _| Ok(()))).collect::<Result<Vec<Outcome>>>()?;
    page.say(
        "Other ways to use the Vulkan API, one at a time, against the default. Each computes the same, bit for bit, \
         unless the table says otherwise. All intervals of an axis hold together with 95 %; one that leaves out 1 is \
         a difference. The command vary measures this for any scene.",
    );
    page.plot(&strips(&scene.name, &outcomes)?, true);
    let mut rows = Vec::new();
    for outcome in &outcomes {
        let mut timed = outcome.timed();
        for (variant, tried) in outcome.asked.variants.iter().zip(&outcome.tried) {
            rows.push(match tried {
                Tried::Lacks(lack) => {
                    vec![variant.name.clone(), format!("not run: {lack}"), String::new(), String::new()]
                }
                Tried::Proved(proof) => {
                    let frame = timed.next().and_then(|(_, rows)| rows.iter().find(|row| row.what == "frame"));
                    let ratio = frame.map_or_else(String::new, |row| {
                        format!("{:.3} ({:.3} to {:.3})", row.ratio.value, row.ratio.low, row.ratio.high)
                    });
                    let shows = frame.and_then(|row| row.finding()).unwrap_or_default();
                    vec![variant.name.clone(), proof.to_string(), ratio, shows.into()]
                }
            });
        }
    }
    let columns = [
        ("variant", "axis and value"),
        ("what was proved", "against all buffers of the default"),
        ("frame", "time over that of the default, and its interval"),
        ("shows", "what the interval shows"),
    ];
    page.table("vary", &Table::new(columns, rows))
}
