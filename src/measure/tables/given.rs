//! Comparison with curves of figures 3 and 4 from a CSV file; the columns tell which figure it is.

use std::path::Path;

use super::curves::{Point, figure_3, figure_4};
use crate::error::{Error, Input, Result};

/// Largest differences between a file's values and ours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Agreement {
    /// The figure, 3 or 4.
    pub figure: u32,
    /// Rows that match one of our points.
    pub rows: usize,
    /// Relative difference of the reference values.
    pub exact: f64,
    /// Rows with the same number of segments as ours, for both sources together in figure 3, for one in figure 4.
    /// Where an edge is halved to exactly 2/5 of its distance, which occurs in figure 4 at every size, rounding
    /// decides.
    pub segments: usize,
    /// Difference of the relative errors of the paper's evaluation in these rows, absolute.
    pub paper: f64,
    /// Relative difference of the standard deviations of random samples.
    pub scatter: f64,
}

/// Reads a file and compares.
pub fn compare(path: &Path) -> Result<Agreement> {
    let fault = |what: String| Error::from(Input::new(what).file(path));
    let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    compare_text(&text).map_err(fault)
}

/// Compares the text of a file; an error is a message.
pub fn compare_text(text: &str) -> std::result::Result<Agreement, String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let column = |name: &str| header.iter().position(|h| h == name).ok_or(format!("there is no column `{name}`"));
    let third = column("tip_distance_cm").is_ok();
    // Column names, and millimetres per unit of the distance.
    let (place, unit, segments, error, scatter, samples) = if third {
        ("tip_distance_cm", 10.0, "n_segments", "relerr_paper", "MC12_rel_rms", Some(12.0))
    } else {
        ("base_distance_mm", 1.0, "segments_eq19", "relerr_eq19", "JB_rel_rms", None)
    };
    let columns = [place, "F_reference", segments, error, scatter];
    let columns = columns.map(column).into_iter().collect::<std::result::Result<Vec<usize>, String>>()?;
    let channel = column("channel")?;
    let points = if third { figure_3() } else { figure_4() };

    let mut found = Agreement { figure: if third { 3 } else { 4 }, ..Agreement::default() };
    for row in reader.records() {
        let row = row.map_err(|error| error.to_string())?;
        let cell = |k: usize| row.get(k).unwrap_or_default();
        let mut values = [0.0; 5];
        for (value, column) in values.iter_mut().zip(&columns) {
            let text = cell(*column);
            *value = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
        }
        let [at, reference, count, wrong, rms] = values;
        let here = |p: &&Point| {
            "RGB".chars().nth(p.channel) == cell(channel).chars().next()
                && (p.place / unit - at).abs() < 1e-5 * at.max(1e-5)
        };
        let Some(point) = points.iter().find(here) else { continue };
        found.rows += 1;
        found.exact = found.exact.max((point.exact / reference - 1.0).abs());
        let ours = if third { point.paper.segments } else { point.paper.segments / 2 };
        if ours as f64 == count {
            found.segments += 1;
            found.paper = found.paper.max((point.error(point.paper.value) - wrong).abs());
        }
        let n = samples.unwrap_or(point.discs as f64);
        found.scatter = found.scatter.max((point.scatter / n.sqrt() / rms - 1.0).abs());
    }
    if found.rows == 0 { Err("no row has a place of the figure".into()) } else { Ok(found) }
}
