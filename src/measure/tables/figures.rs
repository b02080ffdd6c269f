//! Figures 3 and 4 as text, and the comparison with curves from a file. The paper prints its curves without numbers,
//! so its claims are compared with our implementation of its method.

use std::path::Path;

use super::curves::{self, Point, TOLERANCES};
use super::{Tell, Told};
use crate::error::Result;

const COLORS: [&str; 3] = ["R", "G", "B"];

/// Largest magnitude of `of` over the points of a channel.
fn largest(points: &[Point], channel: usize, of: impl Fn(&Point) -> f64) -> f64 {
    points.iter().filter(|p| p.channel == channel).map(|p| of(p).abs()).fold(0.0, f64::max)
}

/// Figure 3: one line every two millimetres, and the worst values of each channel.
pub fn figure_3(tell: Tell<'_>) {
    let mut tell = |words: &str| tell(Told::Words(words));
    let points = curves::figure_3();
    tell(
        "Figure 3: F of a triangle of skim milk, base 10 mm, height 5 mm, tip 0 to 10 mm from the receiver, in its \
         plane.",
    );
    tell("Paper: its method and 10,000 random samples give virtually the same curve; 12 samples, low accuracy.");
    tell(&format!(
        "{:>2} {:>6} {:>11} | {:>8} {:>9} | {:>5} {:>9} {:>5} {:>9} | {:>9} {:>9}",
        "", "tip", "exact", "segments", "error", "evals", "error", "evals", "error", "12", "10000"
    ));
    tell(&format!(
        "{:>2} {:>6} {:>11} | {:>18} | ours {:>10.0e} {:>15.0e} | {:>19}",
        "", "mm", "", "paper's, a source", TOLERANCES[0], TOLERANCES[1], "random samples, rms"
    ));
    for p in points.iter().filter(|p| (p.place / 2.0 - (p.place / 2.0).round()).abs() < 1e-9) {
        tell(&row(p, &[p.scatter / 12f64.sqrt(), p.scatter / 100.0], COLORS[p.channel]));
    }
    for (c, color) in COLORS.iter().enumerate() {
        let scatter = largest(&points, c, |p| p.scatter) / 12f64.sqrt();
        tell(&worst(
            &points,
            c,
            color,
            &format!("12 samples {scatter:.0e}, 10,000 {:.0e}", scatter * (0.0012f64).sqrt()),
        ));
    }
}

/// Figure 4: one line every half decade for green, and the worst values of each channel.
pub fn figure_4(tell: Tell<'_>) {
    let mut tell = |words: &str| tell(Told::Words(words));
    let points = curves::figure_4();
    tell("Figure 4: F of a triangle of marble, tip at the receiver, base 0.1 to 100 mm away, twice as wide as far.");
    tell(
        "Paper: its method needs far fewer samples than Jensen and Buhler's criterion, which are too few to be \
         accurate.",
    );
    tell(&format!(
        "{:>2} {:>6} {:>11} | {:>8} {:>9} | {:>5} {:>9} {:>5} {:>9} | {:>9} {:>9}",
        "", "base", "exact", "segments", "error", "evals", "error", "evals", "error", "samples", "rms error"
    ));
    for p in points
        .iter()
        .filter(|p| p.channel == 1 && ((2.0 * p.place.log10()).round() / 2.0 - p.place.log10()).abs() < 1e-9)
    {
        tell(&row(p, &[p.discs as f64, p.scatter / (p.discs as f64).sqrt()], COLORS[1]));
    }
    for (c, color) in COLORS.iter().enumerate() {
        let discs = largest(&points, c, |p| p.discs as f64);
        let rms = largest(&points, c, |p| p.scatter / (p.discs as f64).sqrt());
        let loose = largest(&points, c, |p| p.loose.segments as f64 / 2.0);
        let more = format!("samples {discs:.0}, rms {rms:.0e}; without the rule on sigma {loose:.0} segments");
        tell(&worst(&points, c, color, &more));
    }
}

/// One point; the last two numbers differ between the figures.
fn row(p: &Point, last: &[f64; 2], color: &str) -> String {
    let [a, b] = p.ours.map(|(evaluations, value)| format!("{evaluations:>5} {:>9.1e}", p.error(value)));
    let own = last.map(|x| if x >= 1.0 { format!("{x:>9.0}") } else { format!("{x:>9.3}") }).join(" ");
    let (segments, error) = (p.paper.segments / 2, p.error(p.paper.value));
    format!("{color:>2} {:>6.2} {:>11.4e} | {segments:>8} {error:>9.1e} | {a} {b} | {own}", p.place, p.exact)
}

/// The worst values of a channel over the whole curve.
fn worst(points: &[Point], c: usize, color: &str, more: &str) -> String {
    let segments = largest(points, c, |p| p.paper.segments as f64 / 2.0);
    let paper = largest(points, c, |p| p.error(p.paper.value));
    let [a, b] = [0, 1].map(|k| largest(points, c, |p| p.error(p.ours[k].1)));
    format!(
        "   {color}, whole curve: paper's method {segments:.0} segments, error {paper:.1e}; ours {a:.1e}, {b:.1e}; \
         {more}"
    )
}

/// Compares a file with our curves of either figure.
pub fn given(path: &Path, tell: Tell<'_>) -> Result<()> {
    let mut tell = |words: &str| tell(Told::Words(words));
    let found = super::given::compare(path)?;
    tell(&format!(
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
    ));
    Ok(())
}
