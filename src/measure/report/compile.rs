//! The section on compilers of GPUs that are not here.

use super::{Bench, Page};
use crate::error::Result;
use crate::scene::Scene;

/// The families: RDNA2, and RDNA3 by the names that older and newer versions of Mesa have for it.
const FAMILIES: [&str; 3] = ["navi21", "gfx1100", "navi31"];

/// Shows what these compilers make of a scene's kernels.
pub fn compile(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let name = bench.either("sphere", "lotus");
    let Some(compilers) = bench.compilers else {
        page.say("The command milkglass compile shows this.");
        return Ok(());
    };
    page.say(&format!(
        "The pipelines of {name} as Mesa's RADV compiles them for GPUs that need not be here. Nothing runs: cycles are \
         the compiler's estimate. The command compile does this for any scene."
    ));
    let scene = Scene::load(name)?;
    for family in FAMILIES {
        match compilers(&scene, &[family]) {
            Ok(tables) => tables.iter().try_for_each(|(heading, table)| {
                page.head(heading);
                page.table(&format!("compile-{family}"), table)
            })?,
            Err(error) => page.say(&format!("{family} is not shown: {error}")),
        }
    }
    Ok(())
}
