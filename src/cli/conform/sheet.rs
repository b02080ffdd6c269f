//! The tables that `conform` prints.

use crate::cli::table;
use milkglass::internals::gpu::Device;
use milkglass::measure::bias::farthest;
use milkglass::measure::conform::{BINS, Row};
use milkglass::measure::leaning::of_stage;

/// The largest difference in per cent of what the tolerance allows.
fn of_tolerance(used: f64) -> String {
    match 100.0 * used {
        0.0 => "0 %".into(),
        percent if percent < 1.0 => "<1 %".into(),
        percent if percent.is_finite() => format!("{percent:.0} %"),
        _ => "NaN".into(),
    }
}

/// The table of comparisons, followed by the histogram of distances.
pub(super) fn text(rows: &[(Device, Row)]) -> String {
    let cells: Vec<_> = rows
        .iter()
        .map(|(device, row)| {
            // Near zero, a distance in units in the last place is meaningless.
            let ulp = match row.ulp {
                u64::MAX => "NaN".to_string(),
                1_000_001.. => "-".to_string(),
                ulp => ulp.to_string(),
            };
            let verdict = if row.faults.is_empty() { "conforms".to_string() } else { "DIFFERS".to_string() };
            let relative = format!("{:.1e}", row.relative);
            let mut cells = vec![device.name().to_string(), row.fixture.clone(), row.stage.to_string()];
            cells.extend([row.words.to_string(), ulp, relative, of_tolerance(row.used), verdict]);
            cells
        })
        .collect();
    let header = ["device", "fixture", "stage", "words", "ulp", "relative", "of tolerance", "verdict"];
    let mut text = table(&header, &[3, 4, 5, 6], &cells);

    // Sum the histograms over all fixtures.
    let mut sums: Vec<(String, &str, [u64; 8])> = Vec::new();
    for (device, row) in rows {
        match sums.iter_mut().find(|sum| sum.0 == device.name() && sum.1 == row.stage) {
            Some(sum) => sum.2.iter_mut().zip(row.histogram).for_each(|(sum, count)| *sum += count),
            None => sums.push((device.name().to_string(), row.stage, row.histogram)),
        }
    }
    let share = |count: u64, all: u64| match 100.0 * count as f64 / all as f64 {
        _ if count == 0 => ".".to_string(),
        percent if percent < 0.01 => "<0.01".to_string(),
        percent => format!("{percent:.2}"),
    };
    let row = |(device, stage, counts): &(String, &str, [u64; 8])| {
        let all: u64 = counts.iter().sum();
        let shares = counts.iter().map(|&count| share(count, all));
        let own = rows.iter().filter(|(other, _)| other.name() == device).map(|(_, row)| row);
        let mean = farthest(&of_stage(own, stage)).map_or("-".into(), |mean| format!("{mean:+.0e}"));
        [device.clone(), (*stage).to_string(), all.to_string()].into_iter().chain(shares).chain([mean]).collect()
    };
    let cells: Vec<Vec<String>> = sums.iter().filter(|sum| sum.2.iter().any(|&count| count > 0)).map(row).collect();
    let up_to = BINS.map(|most| format!("<={most}"));
    let beyond = format!(">{}", BINS[BINS.len() - 1]);
    let header: Vec<&str> = ["device", "stage", "floats"]
        .into_iter()
        .chain(up_to.iter().map(String::as_str))
        .chain([beyond.as_str(), "mean"])
        .collect();
    text += "\nfloats by their distance from the reference in units in the last place, per cent of all; `mean`: of the signed \
             relative differences, of the buffer that is farthest off\n";
    text + &table(&header, &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11], &cells) + "\n"
}
