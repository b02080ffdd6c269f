//! How long a frame would take on another device, as a table.

use super::{Arguments, check_messages, print, write};
use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::measure::interpret::stage::Interpreter;
use milkglass::measure::profile::{Model, Predicted, Prediction, Settings, predict, predict_interpreted};
use milkglass::measure::table::Table;
use milkglass::scene::Scene;

/// Counts on the device at hand, with the user's kernels if there are any, predicts, prints, and writes the file of
/// `--csv`; the built-in kernels are counted beside the user's.
pub(super) fn run(
    arguments: &Arguments,
    model: &Model,
    scene: &Scene,
    (built_in, own): (&Device, Option<&Device>),
    settings: &Settings,
) -> Result<()> {
    let device = own.unwrap_or(built_in);
    let found = predict(scene, device, settings, model)?;
    let before = own.map(|_| predict(scene, built_in, settings, model)).transpose()?;
    check_messages(Some(device))?;
    told(arguments, &found, before.as_ref())
}

/// The same on the interpreter, and on that of the built-in kernels if there is one; `check` says whether the first one
/// has run what it should.
pub(super) fn interpreted(
    arguments: &Arguments,
    model: &Model,
    scene: &Scene,
    (interpreter, built_in): (&Interpreter, Option<&Interpreter>),
    check: impl Fn() -> Result<()>,
) -> Result<()> {
    let settings = arguments.settings();
    let predict = |on: &Interpreter| predict_interpreted(scene, on, (&settings, arguments.timed()), model);
    let found = predict(interpreter)?;
    check()?;
    told(arguments, &found, built_in.map(predict).transpose()?.as_ref())
}

fn told(arguments: &Arguments, found: &Prediction, before: Option<&Prediction>) -> Result<()> {
    print(&text(found, before))?;
    arguments.csv.iter().try_for_each(|path| write(path, sheet(found).csv()?))
}

fn text(found: &Prediction, before: Option<&Prediction>) -> String {
    let (device, submissions) = (found.us(), found.submissions as f64 * found.model.submission_us);
    let compared = before.map_or(String::new(), |before| {
        let same = |row: &Predicted| found.rows.iter().any(|own| own.stage == row.stage && own.us() == row.us());
        let told: Vec<String> =
            before.rows.iter().filter(|row| !same(row)).map(|row| format!("; {} {:.1}", row.stage, row.us())).collect();
        format!("with the built-in kernels: {:.0} us{}\n", before.us(), told.concat())
    });
    format!(
        "{} as on {}: predicted, not measured; counted on {}\n\
         a frame: {:.0} us on the device; submissions: {}, {submissions:.0} us\n{compared}\n\
         instructions: of all invocations, in millions; the most of any invocation, dispatch after dispatch: steps, instructions\n\
         that wait for one another; loads of buffers, likewise; shared, loads of shared memory, barriers, exchanges. Then us: launches\n\
         and barriers; dispatches bound by issue, by residence (how many invocations the device holds) and by their chain\n\n{}",
        found.scene,
        found.model.name,
        found.counted_on,
        device,
        found.submissions,
        table(found).text()
    )
}

fn table(found: &Prediction) -> Table {
    let us = |us: f64| format!("{us:.1}");
    let whole = found.us();
    Table::of(
        &found.rows,
        &[
            ("stage", "", &|row: &Predicted| row.stage.clone()),
            ("dispatches", "", &|row| row.dispatches.to_string()),
            ("barriers", "", &|row| row.barriers.to_string()),
            ("invocations", "", &|row| row.invocations.to_string()),
            ("instructions", "", &|row| format!("{:.3}", row.instructions as f64 * 1e-6)),
            ("steps", "", &|row| row.longest_steps.to_string()),
            ("loads", "", &|row| row.longest_loads.to_string()),
            ("shared", "", &|row| row.longest_shared.to_string()),
            ("launches", "", &|row| us(row.launches_us)),
            ("issue", "", &|row| us(row.issue_us)),
            ("residence", "", &|row| us(row.residence_us)),
            ("chain", "", &|row| us(row.chain_us)),
            ("us", "", &|row| us(row.us())),
            ("share", "", &|row| format!("{:.1} %", 100.0 * row.us() / whole.max(f64::MIN_POSITIVE))),
            ("bound by", "", &|row| row.bound().to_string()),
        ],
    )
}

/// All numbers as they are.
fn sheet(found: &Prediction) -> Table {
    Table::of(
        &found.rows,
        &[
            ("scene", "", &|_: &Predicted| found.scene.clone()),
            ("model", "", &|_| found.model.name.clone()),
            ("counted_on", "", &|_| found.counted_on.clone()),
            ("stage", "", &|row| row.stage.clone()),
            ("dispatches", "", &|row| row.dispatches.to_string()),
            ("barriers", "", &|row| row.barriers.to_string()),
            ("invocations", "", &|row| row.invocations.to_string()),
            ("instructions", "", &|row| row.instructions.to_string()),
            ("longest_steps", "", &|row| row.longest_steps.to_string()),
            ("longest_loads", "", &|row| row.longest_loads.to_string()),
            ("longest_shared", "", &|row| row.longest_shared.to_string()),
            ("launches_us", "", &|row| row.launches_us.to_string()),
            ("issue_us", "", &|row| row.issue_us.to_string()),
            ("residence_us", "", &|row| row.residence_us.to_string()),
            ("chain_us", "", &|row| row.chain_us.to_string()),
            ("us", "", &|row| row.us().to_string()),
            ("bound_by", "", &|row| row.bound().to_string()),
        ],
    )
}
