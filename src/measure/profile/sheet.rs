//! A profile as CSV and as JSON.

use serde_json::{Value, json};

use super::{Profile, Quantiles, Row, Work};
use crate::error::Result;
use crate::measure::table::{Column, Table};

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
        let work = |row: &Row, part: fn(Work) -> u64| row.work.map_or_else(String::new, |work| part(work).to_string());
        let columns: [Column<'_, Row>; 33] = [
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
            ("invocations", "", &|row| work(row, |work| work.invocations)),
            ("flops", "", &|row| work(row, |work| work.flops)),
            ("divisions_roots", "", &|row| work(row, |work| work.roots)),
            ("exps", "", &|row| work(row, |work| work.exps)),
            ("bytes_read", "", &|row| work(row, |work| work.read)),
            ("bytes_written", "", &|row| work(row, |work| work.written)),
            ("bytes_loaded", "", &|row| work(row, |work| work.loaded)),
            ("bytes_stored", "", &|row| work(row, |work| work.stored)),
            ("instructions", "", &|row| work(row, |work| work.instructions)),
            ("other_instructions", "", &|row| work(row, |work| work.others)),
            ("subgroups", "", &|row| work(row, |work| work.subgroups)),
            ("issued", "", &|row| work(row, |work| work.issued)),
            ("shared_words", "", &|row| work(row, |work| work.shared)),
            ("atomics", "", &|row| work(row, |work| work.atomics)),
            ("longest_steps", "", &|row| work(row, |work| work.longest_steps)),
            ("longest_loads", "", &|row| work(row, |work| work.longest_loads)),
            ("longest_shared", "", &|row| work(row, |work| work.longest_shared)),
            ("share_copy", "", &|row| shown(self.shares(row)[0])),
            ("share_fma", "", &|row| shown(self.shares(row)[1])),
            ("share_exp", "", &|row| shown(self.shares(row)[2])),
        ];
        Table::of(&self.rows, &columns).csv()
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
