//! A profile as CSV and as JSON.

use serde_json::{Value, json};

use super::{Profile, Quantiles, Row};
use crate::error::{Error, Input, Result};

/// The columns of the CSV.
const COLUMNS: [&str; 24] = [
    "scene",
    "device",
    "driver",
    "frames",
    "stage",
    "steps",
    "dispatches",
    "device_ms",
    "device_ms_p10",
    "device_ms_p90",
    "wall_ms",
    "wall_ms_p10",
    "wall_ms_p90",
    "invocations",
    "flops",
    "divisions_roots",
    "exps",
    "bytes_read",
    "bytes_written",
    "bytes_loaded",
    "bytes_stored",
    "share_copy",
    "share_fma",
    "share_exp",
];

impl Profile {
    /// A stage's shares of the copy, FMA and exponential rate.
    pub fn shares(&self, row: &Row) -> [Option<f64>; 3] {
        self.rates
            .as_ref()
            .map_or([None; 3], |rates| [row.share_of_copy(rates), row.share_of_fma(rates), row.share_of_exp(rates)])
    }

    /// CSV with one row per stage; cells are empty where nothing was measured.
    pub fn csv(&self) -> Result<String> {
        let fault =
            |error: &dyn std::fmt::Display| Error::from(Input::new(format!("the table could not be written: {error}")));
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS).map_err(|error| fault(&error))?;
        for row in &self.rows {
            let mut cells = vec![self.scene.clone(), self.device.clone(), self.driver.clone()];
            cells.extend([
                self.frames.to_string(),
                row.stage.clone(),
                row.steps.to_string(),
                row.dispatches.to_string(),
            ]);
            for spread in [row.device, Some(row.wall)] {
                let show = |of: fn(&Quantiles) -> f64| {
                    spread.as_ref().map_or_else(String::new, |spread| of(spread).to_string())
                };
                cells.extend([show(|s| s.median), show(|s| s.low), show(|s| s.high)]);
            }
            let counts =
                row.work.map(|w| [w.invocations, w.flops, w.roots, w.exps, w.read, w.written, w.loaded, w.stored]);
            cells.extend(counts.map_or([const { String::new() }; 8], |counts| counts.map(|count| count.to_string())));
            cells.extend(self.shares(row).map(|share| share.map_or_else(String::new, |share| share.to_string())));
            writer.write_record(&cells).map_err(|error| fault(&error))?;
        }
        let bytes = writer.into_inner().map_err(|error| fault(&error))?;
        String::from_utf8(bytes).map_err(|error| fault(&error))
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
