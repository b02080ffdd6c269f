//! A profile as CSV and as JSON.

use serde_json::{Value, json};

use super::{Counts, Profile, Quantiles, Row, Work};
use crate::error::Result;
use crate::measure::table::{Column, Table};

/// What is counted of a row, as CSV has it.
const COUNTED: [Counted; 17] = [
    ("invocations", |work| work.invocations),
    ("flops", |work| work.flops),
    ("divisions_roots", |work| work.roots),
    ("exps", |work| work.exps),
    ("bytes_read", |work| work.read),
    ("bytes_written", |work| work.written),
    ("bytes_loaded", |work| work.loaded),
    ("bytes_stored", |work| work.stored),
    ("instructions", |work| work.instructions),
    ("other_instructions", |work| work.others),
    ("subgroups", |work| work.subgroups),
    ("issued", |work| work.issued),
    ("shared_words", |work| work.shared),
    ("atomics", |work| work.atomics),
    ("longest_steps", |work| work.longest_steps),
    ("longest_loads", |work| work.longest_loads),
    ("longest_shared", |work| work.longest_shared),
];

/// A heading, and the number under it.
type Counted = (&'static str, fn(Work) -> u64);

impl Profile {
    /// A stage's shares of the copy, FMA and exponential rate.
    pub fn shares(&self, row: &Row) -> [Option<f64>; 3] {
        self.rates
            .as_ref()
            .map_or([None; 3], |rates| [row.share_of_copy(rates), row.share_of_fma(rates), row.share_of_exp(rates)])
    }

    /// CSV with one row per stage; cells are empty where nothing was measured.
    pub fn csv(&self) -> Result<String> {
        let shown = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
        let device = |row: &Row, part: fn(Quantiles) -> f64| shown(row.device.map(part));
        let work = |(head, part): Counted| {
            let cell = move |row: &Row| row.work.map_or_else(String::new, |work| part(work).to_string());
            (head, Box::new(cell) as Box<dyn Fn(&Row) -> String>)
        };
        let counted = COUNTED.map(work);
        let times: [Column<'_, Row>; 13] = [
            ("scene", "", &|_| self.scene.clone()),
            ("device", "", &|_| self.device.clone()),
            ("driver", "", &|_| self.driver.clone()),
            ("frames", "", &|_| self.frames.to_string()),
            ("stage", "", &|row| row.stage.clone()),
            ("steps", "", &|row| row.steps.to_string()),
            ("dispatches", "", &|row| row.dispatches.to_string()),
            ("device_ms", "", &|row| device(row, |ms| ms.median)),
            ("device_ms_p10", "", &|row| device(row, |ms| ms.low)),
            ("device_ms_p90", "", &|row| device(row, |ms| ms.high)),
            ("wall_ms", "", &|row| row.wall.median.to_string()),
            ("wall_ms_p10", "", &|row| row.wall.low.to_string()),
            ("wall_ms_p90", "", &|row| row.wall.high.to_string()),
        ];
        let shares: [Column<'_, Row>; 3] = [
            ("share_copy", "", &|row| shown(self.shares(row)[0])),
            ("share_fma", "", &|row| shown(self.shares(row)[1])),
            ("share_exp", "", &|row| shown(self.shares(row)[2])),
        ];
        let counted: Vec<Column<'_, Row>> = counted.iter().map(|(head, cell)| (*head, "", &**cell)).collect();
        Table::of(&self.rows, &[&times[..], &counted, &shares].concat()).csv()
    }

    /// The whole profile with all samples, but for the trace; `null` where nothing was measured.
    pub fn json(&self) -> Value {
        let spread =
            |spread: Option<Quantiles>| spread.map(|s| json!({"median": s.median, "p10": s.low, "p90": s.high}));
        let row = |row: &Row| {
            let [copy, fma, exp] = self.shares(row);
            json!({"stage": row.stage, "steps": row.steps, "dispatches": row.dispatches, "device_ms": spread(row.device),
                   "interval_ms": row.interval,
                   "wall_ms": spread(Some(row.wall)), "work": row.work,
                   "share": {"copy": copy, "fma": fma, "exp": exp}})
        };
        json!({
            "scene": self.scene, "device": self.device, "driver": self.driver, "frames": self.frames,
            "frame_wall_ms": spread(Some(self.wall)), "frame_device_ms": spread(self.on_device),
            "peak_bytes": self.peak,
            "rates": self.rates.map(|r| json!({"copy_bytes_per_s": r.copy, "fma_per_s": r.fma, "exp_per_s": r.exp})),
            "stages": self.rows.iter().map(row).collect::<Vec<_>>(),
            "notes": self.notes, "samples": self.samples,
        })
    }
}

/// CSV with one row per stage that an interpreter counted.
pub fn counts_csv(scene: &str, rows: &[Counts]) -> Result<String> {
    let heads = ["scene", "stage", "dispatches"].into_iter().chain(COUNTED.map(|(head, _)| head));
    let row = |Counts { stage, dispatches, work, .. }: &Counts| {
        let counted = COUNTED.map(|(_, part)| part(*work).to_string());
        [scene.to_string(), stage.clone(), dispatches.to_string()].into_iter().chain(counted).collect()
    };
    Table::plain(heads, rows.iter().map(row).collect()).csv()
}
