//! The section on compilers of GPUs that are not here.

use super::{Bench, Page};
use crate::error::Result;
use crate::scene::Scene;

/// The families: RDNA2 and RDNA3.
const FAMILIES: [&str; 2] = ["navi21", "gfx1100"];

/// Shows what these compilers make of a scene's kernels.
pub fn compile(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let name = bench.either("sphere", "lotus");
    let Some(compilers) = bench.compilers else {
        page.say("The command milkglass compile shows this.");
        return Ok(());
    };
    match compilers(&Scene::load(name)?, &FAMILIES) {
        Ok(tables) => {
            page.say(&format!(
                "The pipelines of {name} as Mesa's RADV compiles them for GPUs that need not be here. Nothing runs: \
                 cycles are the compiler's estimate. The command compile does this for any scene."
            ));
            for ((heading, table), family) in tables.iter().zip(FAMILIES) {
                page.head(heading);
                page.table(&format!("compile-{family}"), table)?;
            }
        }
        Err(error) => page.say(&format!("Not shown: {error}")),
    }
    Ok(())
}
