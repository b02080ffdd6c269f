//! Figures 3 and 4 as tables, and the comparison with curves from a file. The paper prints its curves without numbers,
//! so its claims are compared with our implementation of its method.

use std::path::Path;

use super::curves::Point;
use crate::error::Result;
use crate::measure::table::Table;

/// The names of the channels.
pub const NAMES: [&str; 3] = ["red", "green", "blue"];

/// All points of a figure; `place` heads the column of the receiver's distance, mm.
#[must_use]
pub fn points(place: &str, points: &[Point]) -> Table {
    let error = |x: f64| format!("{x:.3e}");
    Table::of(
        points,
        &[
            ("channel", "", &|p| NAMES[p.channel].into()),
            (place, "distance of the receiver, mm", &|p| format!("{:.6}", p.place)),
            ("F", "the form factor, to nearly all digits", &|p| format!("{:.9e}", p.exact)),
            ("paper_segments", "segments that the published method takes per source", &|p| {
                (p.paper.segments / 2).to_string()
            }),
            ("paper_error", "its relative error", &|p| error(p.error(p.paper.value))),
            ("ours_1e-2_error", "relative error of our rule at a tolerance of 1e-2", &|p| error(p.error(p.ours[0].1))),
            ("ours_1e-4_error", "the same at 1e-4", &|p| error(p.error(p.ours[1].1))),
            ("sample_scatter", "standard deviation of a single uniform sample, relative to F", &|p| {
                format!("{:.4}", p.scatter)
            }),
            ("discs", "samples that the criterion of Jensen and Buhler asks for", &|p| p.discs.to_string()),
        ],
    )
}

/// The worst values of each channel over a whole figure.
#[must_use]
pub fn worst(points: &[Point]) -> Table {
    let largest = |channel: &usize, value: &dyn Fn(&Point) -> f64| {
        points.iter().filter(|p| p.channel == *channel).map(|p| value(p).abs()).fold(0.0, f64::max)
    };
    let error = |channel: &usize, value: &dyn Fn(&Point) -> f64| format!("{:.1e}", largest(channel, value));
    Table::of(
        &[0, 1, 2],
        &[
            ("worst of", "channel, over the whole curve", &|c| NAMES[*c].into()),
            ("paper's segments", "of the published method, per source", &|c| {
                largest(c, &|p| p.paper.segments as f64 / 2.0).to_string()
            }),
            ("without sigma", "its segments without the part of condition 19 that contains sigma", &|c| {
                largest(c, &|p| p.loose.segments as f64 / 2.0).to_string()
            }),
            ("its error", "relative", &|c| error(c, &|p| p.error(p.paper.value))),
            ("ours at 1e-2", "relative error of our rule", &|c| error(c, &|p| p.error(p.ours[0].1))),
            ("ours at 1e-4", "relative error of our rule", &|c| error(c, &|p| p.error(p.ours[1].1))),
            ("12 samples", "root mean square of the relative error of random samples", &|c| {
                error(c, &|p| p.scatter / 12f64.sqrt())
            }),
            ("10,000 samples", "the same of that many", &|c| error(c, &|p| p.scatter / 100.0)),
            ("discs", "samples that the criterion of Jensen and Buhler asks for", &|c| {
                largest(c, &|p| p.discs as f64).to_string()
            }),
            ("their error", "root mean square of the relative error of as many random samples", &|c| {
                error(c, &|p| p.scatter / (p.discs as f64).sqrt())
            }),
        ],
    )
}

/// How the curves of a file differ from ours of the same figure, in words.
pub fn given(path: &Path) -> Result<String> {
    let found = super::given::compare(path)?;
    Ok(format!(
        "{}: figure {}, {} rows: F differs by {:.1e} of itself at most; {} rows have the same number of segments \
         (where an edge is halved to exactly 2/5 of its distance rounding decides), there the error of the paper's \
         method differs by {:.1e}; the scatter of random samples differs by {:.1e} of itself",
        path.display(),
        found.figure,
        found.rows,
        found.exact,
        found.segments,
        found.paper,
        found.scatter
    ))
}
