//! What kernels do in a frame, counted by the interpreter, without a device, as a table.

use super::text::millions;
use super::{Arguments, predicted, print, ready_for, write};
use crate::cli::size;
use milkglass::error::{Error, Result};
use milkglass::measure::interpret::stage::{Interpreter, LANES, SUBGROUP, Settings};
use milkglass::measure::profile::{Counts, Model, counts_csv, interpreted};
use milkglass::measure::table::Table;

/// Counts, prints, and writes the file of `--csv`.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    arguments.counts_only()?;
    ready_for(arguments.files())?;
    let scene = arguments.scene()?.load()?;
    let on = |kernels| Interpreter::with(Settings::counting(), kernels);
    let interpreter = on(arguments.replace.load()?);
    let unused =
        || arguments.replace.unused(&interpreter.asked(), &scene.name).map_or(Ok(()), |fault| Err(fault.into()));
    if let Some(model) = arguments.model.as_deref().map(Model::read).transpose()? {
        let built_in = (!arguments.replace.pairs().is_empty()).then(|| on(Vec::new()));
        return predicted::interpreted(arguments, &model, &scene, (&interpreter, built_in.as_ref()), unused);
    }
    let found = interpreted(&scene, &interpreter, &arguments.settings(), arguments.timed())?;
    unused()?;
    if found.is_empty() {
        return Err(Error::Check("nothing was counted: the frame runs no kernel".into()));
    }
    print(&format!(
        "{}, a frame counted on the interpreter, of which nothing is timed: {LANES} invocations an item, subgroups of {SUBGROUP}\n\n\
         read and written: each byte bound once, no more than asked for; asked: by all loads and stores; in millions: instructions,\n\
         additions and multiplications, divisions and roots, exponentials and the like; the most of any invocation, dispatch after\n\
         dispatch: steps, instructions that wait for one another; loads of buffers, likewise; shared, loads of shared memory, barriers,\n\
         exchanges\n\n{}",
        scene.name,
        table(&found).text()
    ))?;
    arguments.csv.iter().try_for_each(|path| write(path, counts_csv(&scene.name, &found)?))
}

fn table(found: &[Counts]) -> Table {
    Table::of(
        found,
        &[
            ("stage", "", &|row: &Counts| row.stage.clone()),
            ("dispatches", "", &|row| row.dispatches.to_string()),
            ("invocations", "", &|row| row.work.invocations.to_string()),
            ("instructions", "", &|row| millions(row.work.instructions)),
            ("read", "", &|row| size(row.work.read)),
            ("written", "", &|row| size(row.work.written)),
            ("asked", "", &|row| size(row.work.loaded + row.work.stored)),
            ("flop", "", &|row| millions(row.work.flops)),
            ("div", "", &|row| millions(row.work.roots)),
            ("exp", "", &|row| millions(row.work.exps)),
            ("steps", "", &|row| row.work.longest_steps.to_string()),
            ("loads", "", &|row| row.work.longest_loads.to_string()),
            ("shared", "", &|row| row.work.longest_shared.to_string()),
        ],
    )
}
