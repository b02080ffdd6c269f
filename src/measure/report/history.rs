//! Section `history`: how the times of stages went over many runs.

use super::{Bench, Page};
use crate::error::Result;
use crate::measure::profile::history::courses;

/// Draws the runs that were given.
pub fn history(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(entries) = bench.history else {
        page.say("No file of runs was given.");
        return Ok(());
    };
    page.say(
        "Medians of the stages in runs of milkglass profile --history, with their intervals of 95 %. Runs differ by \
         load, heat and where memory lies, too: only a comparison in turn tells whether a change made it.",
    );
    for (k, course) in courses(entries).iter().enumerate() {
        page.head(&course.title());
        page.plot(&course.svg()?, false);
        page.table(&format!("history-{}", k + 1), &course.table())?;
    }
    Ok(())
}
