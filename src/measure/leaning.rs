//! Which stages' values lean to one side, in a fixture or over all of them.

use super::bias::{Bias, add};
use super::conform::Row;

/// The differences of a stage over all of these rows.
#[must_use]
pub fn of_stage<'a>(rows: impl IntoIterator<Item = &'a Row>, stage: &str) -> Vec<Bias> {
    let mut sums = Vec::new();
    rows.into_iter().filter(|row| row.stage == stage).for_each(|row| add(&mut sums, &row.distances.biases));
    sums
}

/// Adds a fault to each row whose values lean to one side. If none of a stage's rows does so, but all of them together,
/// its last row gets the fault. All rows are of one device.
pub fn blame(rows: &mut [Row]) {
    let leaning = |biases: &[Bias], place: &str| -> Vec<String> {
        biases.iter().filter(|bias| bias.leans()).map(|bias| bias.fault(place)).collect()
    };
    for last in (0..rows.len()).rev() {
        let stage = rows[last].stage;
        if rows[last + 1..].iter().any(|row| row.stage == stage) {
            continue;
        }
        let mut known = false;
        for row in rows.iter_mut().filter(|row| row.stage == stage) {
            let own = leaning(&row.distances.biases, "");
            known |= !own.is_empty();
            row.faults.extend(own);
        }
        if !known {
            let all = leaning(&of_stage(&*rows, stage), "over all fixtures ");
            rows[last].faults.extend(all);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::bias::farthest;
    use crate::measure::compare::Distances;

    #[test]
    fn rows_of_a_stage_count_together() {
        let row = |off: f32| {
            let pairs = (0..50).map(|k| (1.0 + k as f32, (1.0 + k as f32) * (1.0 + off)));
            let distances = Distances { biases: vec![Bias::of("radiosity", "", pairs)], ..Distances::default() };
            Row { stage: "push", steps: 1, distances, ..Row::default() }
        };
        let mut rows = vec![row(3e-5), row(3e-5), row(3e-5)];
        blame(&mut rows);
        assert!(rows[0].faults.is_empty() && rows[2].faults.len() == 1, "{rows:?}");
        assert!(rows[2].faults[0].starts_with("over all fixtures radiosity is off by +3.0e-5 of itself"), "{rows:?}");
        assert!((farthest(&of_stage(&rows, "push")).unwrap_or_default() - 3e-5).abs() < 1e-7);
        let mut rows = vec![row(0.0), row(3e-8)];
        blame(&mut rows);
        assert!(rows.iter().all(|row| row.faults.is_empty()));
    }
}
