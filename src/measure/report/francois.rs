//! Francois et al. 2006: table 2 and figure 14, layers beneath the surface.

use super::chart::{Axis, Line, chart};
use super::pictures::{Shot, scene};
use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::layers::{Line as Measured, approximations, rules};
use crate::render::plan::Transport;
use crate::scene::Integration;

/// Samples as in table 2.
const SAMPLES: [u32; 3] = [10, 50, 100];
const RULES: [(Integration, &str); 2] = [(Integration::Paper, "paper's rule"), (Integration::Exact, "ours")];

fn named(rule: Integration) -> &'static str {
    RULES.iter().find(|(known, _)| *known == rule).map_or("", |(_, name)| name)
}

/// Errors and times by the samples, the approximations one by one, and the fish.
pub fn francois(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("Table 2: samples, error and time");
    page.say(
        "Error of the integration alone, against the same march converged, and in all, against the layered volume itself. The \
         paper has frames a second with 10, 50 and 100 samples on a GeForce 7800 GTX: fish 126, 51, 20; gecko 120, 33, 16.",
    );
    let size = bench.either([120, 90], [800, 600]);
    let (pixels, repeat) = bench.either((24, 3), (240, 7));
    let mut rows = Vec::new();
    for name in ["slab-layers", "fish", "gecko"] {
        let lines = rules(&scene(name, size, &[])?, bench.device, &SAMPLES, pixels, repeat)?;
        for line in &lines {
            rows.push(vec![
                name.to_string(),
                named(line.rule).into(),
                line.samples.to_string(),
                format!("{:.1e}", line.integration),
                format!("{:.1e}", line.total),
                format!("{:.2}", line.relief),
                format!("{:.2}", line.view),
            ]);
        }
        if name == "fish" {
            let of = |rule: Integration| lines.iter().filter(move |line| line.rule == rule);
            let error = |rule| Line::new(named(rule), of(rule).map(|line: &Measured| (line.relief, line.integration)));
            page.plot(
                &chart(
                    "Fish: error of the integration by time",
                    Axis { label: "stage relief, ms", log: true },
                    Axis { label: "relative error, L2", log: true },
                    &RULES.map(|(rule, _)| error(rule)),
                )?,
                false,
            );
        }
        let at = |rule, samples| lines.iter().find(|line| line.rule == rule && line.samples == samples);
        if let (Some(ours), Some(theirs), Some(same)) =
            (at(Integration::Exact, 10), at(Integration::Paper, 100), at(Integration::Paper, 10))
        {
            let cost = ours.relief / same.relief;
            let tone = if ours.integration <= theirs.integration { Tone::Win } else { Tone::Loss };
            page.find(
                tone,
                &format!(
                    "{name}: 10 samples of ours err by {:.1e}, 100 of the paper's rule by {:.1e}; a sample costs {cost:.2} times as much",
                    ours.integration, theirs.integration
                ),
            );
        }
    }
    let header = ["scene", "rule", "samples", "L2 of integration", "L2 in all", "relief, ms", "a view, ms"];
    page.table("layers", &header, &rows)?;

    page.head("Each approximation by itself");
    let mut rows = Vec::new();
    for name in ["fish", "gecko"] {
        for (what, error) in approximations(&scene(name, bench.either([100, 75], [400, 300]), &[])?, pixels / 4)? {
            rows.push(vec![name.to_string(), what.to_string(), format!("{error:.1e}")]);
        }
    }
    page.table("layers-approximations", &["scene", "approximation", "L2"], &rows)?;

    page.head("Figure 14: the fish by its samples");
    let size = bench.either([240, 180], [480, 360]);
    for samples in SAMPLES {
        let shoot = |(rule, _): (Integration, &str)| {
            let mut scene = scene("fish", size, &[])?;
            for layers in scene.objects.iter_mut().filter_map(|object| object.material.layers.as_mut()) {
                (layers.samples, layers.integration) = (samples, rule);
            }
            Shot::take(&scene, bench.device, Transport::Hierarchy)
        };
        let [paper, ours] = [shoot(RULES[0])?, shoot(RULES[1])?];
        let (mean, map) = ours.apart(&paper)?;
        let label = |name: &str| format!("{name}, {samples} samples");
        page.pictures(&[
            paper.show(label(RULES[0].1))?,
            ours.show(label(RULES[1].1))?,
            map.show(format!("difference, FLIP {mean:.1e}"))?,
        ]);
    }
    Ok(())
}
