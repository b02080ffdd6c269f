//! Section `kubo`: the function itself, sigma_0 from balls, pictures, curvature, and the limits of the method.

use super::pictures::{Shot, scene};
use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::balls::fit::{channels, svg};
use crate::measure::local::{PAPER, balls, bending, curve, detail, panels, table_1};
use crate::measure::plot::{Axis, CHANNELS, Panel, Series};
use crate::measure::table::Table;
use crate::measure::validity::{ASKED, lambert_share, places, share, svg as svg_by_thickness, verdict};
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{Camera, PRESETS, Preset, Scene};
use crate::session::curvature_view::curvature_view;
use crate::session::run::Session;

/// Writes the whole section.
pub fn kubo(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    function(page)?;
    figure2(bench, page)?;
    table(bench, page)?;
    for name in bench.either(&["Skin1"][..], &["Skin1", "Marble", "Skimmilk"]) {
        fitted(bench, page, Preset::named(name).unwrap_or(&PRESETS[0]))?;
    }
    compared(bench, page)?;
    trusted(bench, page)
}

/// Settings of the built-in scenes: none, or a coarser mesh for a quick report.
fn coarser(bench: &Bench<'_>) -> &'static [&'static str] {
    bench.either(&["object.0.detail=64"], &[])
}

/// f over the angle, as in figures 4 and 7.
fn function(page: &mut Page) -> Result<()> {
    page.head("The curvature-dependent reflectance function");
    page.say(
        "The reflectance f against the angle between normal and light. At sigma 0 it is Lambert's cosine; the larger \
         sigma = sigma_0 kappa is, the farther light reaches beyond 90 degrees. On a ball of skin red reaches \
         farthest, and farther on a smaller ball.",
    );
    let panel = |title: &str, lines: Vec<Series>| {
        Panel::new(title, [Axis::linear("angle from the light, degrees"), Axis::linear("f, no unit")], lines).svg()
    };
    let line = |sigma: f64| Series::line(format!("sigma {sigma} rad"), curve(sigma, 181).iter().map(|p| (p[0], p[1])));
    let mut plots = vec![panel("Figure 4: f by sigma", [0.0, 0.1, 0.25, 0.5, 1.0, 2.0].map(line).to_vec())?];
    let skin = Scene::load_with("sphere", &["object.0.material.preset=skin1".into()])?;
    for ball in balls(&skin, &[20.0, 5.0], 181)? {
        let channel = |c: usize| {
            let name = format!("{}, sigma {:.3} rad", NAMES[c], ball.sigma[c]);
            Series::line(name, ball.curve.iter().map(|p| (p[0], p[c + 1]))).colored(CHANNELS[c])
        };
        let title = format!("Figure 7: a ball of skin, radius {} mm", ball.radius);
        plots.push(panel(&title, [0, 1, 2].map(channel).to_vec())?);
    }
    page.plots(&plots);
    Ok(())
}

const NAMES: [&str; 3] = ["red", "green", "blue"];

/// Figure 2: small bumps without and with scattering.
pub fn figure2(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("Figure 2: small bumps without and with scattering");
    page.say(
        "The same surface by Lambert's cosine and by the dipole, without shadows. The paper shows the Stanford bunny, \
         and light that spreads in it hides its wrinkles; here are a ball with bumps a tenth of its width apart, and \
         the meshes of the command. Detail is the root mean square of what a pixel has beyond the mean of 7 x 7 pixels \
         about it, over the mean pixel.",
    );
    let side = bench.either(200, 512);
    let (mut shown, mut rows) = (Vec::new(), Vec::new());
    for name in ["sphere"].into_iter().chain(bench.meshes.iter().map(String::as_str)) {
        let mut scene = scene(name, [side; 2], if name == "sphere" { &[BUMPS] } else { &[] })?;
        scene.lights.iter_mut().for_each(|light| light.shadows = false);
        let mut found = [0.0; 2];
        for (found, (transport, called)) in found.iter_mut().zip(WITHOUT_AND_WITH) {
            let mut session = Session::new(&scene, bench.device, Options { transport, ..Options::default() })?;
            session.frame(Change::EVERYTHING)?;
            *found = detail(&mut session, 3)?;
            shown.push(Shot::of(&session.picture()?, f64::NAN).show(format!("{name}: {called}"))?);
        }
        let aim = format!("{name}: scattering hides small bumps");
        if found[0] > 0.0 {
            page.find(Tone::of(found[1] < found[0]), &aim, &format!("detail {:.3} -> {:.3}", found[0], found[1]));
        } else {
            page.say(&format!("{name}: no detail, since no 7 x 7 pixels show it alone."));
        }
        let ratio = if found[0] > 0.0 { format!("{:.2}", found[1] / found[0]) } else { "-".into() };
        rows.push([vec![name.to_string()], found.map(|x| format!("{x:.4}")).to_vec(), vec![ratio]].concat());
    }
    page.pictures(&shown);
    let columns =
        [("scene", ""), ("Lambert", "detail of the picture"), ("dipole", "the same"), ("dipole / Lambert", "")];
    page.table("kubo-figure-2", &Table::new(columns, rows))
}

const WITHOUT_AND_WITH: [(ShadingMethod, &str); 2] =
    [(ShadingMethod::Lambert, "without scattering (Lambert)"), (ShadingMethod::Hierarchy, "with scattering (dipole)")];
/// Bumps on the ball of 10 mm.
const BUMPS: &str = "object.0.deform=[{ type = 'noise', amplitude = 0.3, scale = 1 }]";

/// The meshes of table 1: name, built-in scene, settings for a full and for a quick report. Texture blur needs
/// one-to-one texture coordinates, which among the shapes only the ball has.
const MESHES: [(&str, &str, [&[&str]; 2]); 4] = [
    ("bust", "bust", [&[OPEN_SKY], &["object.0.detail=64", OPEN_SKY]]),
    ("lotus", "lotus", [&[], &["object.0.detail=48"]]),
    ("ball", "sphere", [&["transport.unwrap=true", "object.0.detail=7"], &["transport.unwrap=true", QUICK_BLUR]]),
    (
        "lumpy ball",
        "sphere",
        [&["transport.unwrap=true", "object.0.detail=7", LUMPS], &["transport.unwrap=true", QUICK_BLUR, LUMPS]],
    ),
];
/// Turns environment occlusion off: its rays would cost many times as much as the shading.
const OPEN_SKY: &str = "light.0.occlusion=0";
const QUICK_BLUR: &str = "transport.blur_texture=128";
const LUMPS: &str = "object.0.deform=[{ type = 'noise', amplitude = 1, scale = 5 }]";

/// Table 1: cost and error of each technique.
pub fn table(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("Table 1: what shading costs");
    page.say(
        "Shading alone, without visibility and shadows, techniques alternating. Texture blur needs texture coordinates \
         that are one to one, which not all meshes have.",
    );
    let side = bench.either(256, 1024);
    let mut rows = Vec::new();
    for (name, base, [full, quick]) in MESHES {
        let sets = bench.either(quick, full);
        for row in table_1(&scene(base, [side; 2], sets)?, bench.device, bench.either(25, 101))? {
            let paper = PAPER.iter().find(|(technique, ..)| *technique == row.technique);
            let theirs = |fps: fn(&(&str, f64, f64)) -> f64| paper.map_or(String::new(), |p| fps(p).to_string());
            let slower = |fps: fn(&(&str, f64, f64)) -> f64| {
                paper.map_or(String::new(), |p| format!("{:.2}", fps(&PAPER[0]) / fps(p)))
            };
            rows.push(vec![
                name.to_string(),
                row.technique.to_string(),
                format!("{:.3}", row.shading),
                format!("{:.3}", row.ratio),
                format!("{:.1}", row.frame),
                format!("{:.3}", row.error),
                theirs(|p| p.1),
                theirs(|p| p.2),
                slower(|p| p.1),
                slower(|p| p.2),
            ]);
            let most = if row.technique == "CDRF, table" { 1.05 } else { 1.15 };
            if row.technique.starts_with("CDRF") {
                let aim = format!("{name}: {} shades in at most {most} of Lambert's time", row.technique);
                page.find(Tone::of(row.ratio <= most), &aim, &format!("{:.2}", row.ratio));
            }
        }
        let bend = bending(&scene(base, [1, 1], sets)?, bench.device, bench.either(1, 5))?;
        let share = bend.curvature / bend.solve;
        let aim = format!("{name}: curvature takes at most 0.2 of a solve of the hierarchy");
        let found = format!("{share:.1e}: {:.2} ms for {} vertices", bend.curvature, bend.vertices);
        page.find(Tone::of(share <= 0.2), &aim, &found);
    }
    let columns = [
        ("scene", ""),
        ("technique", ""),
        ("shading, ms", "time of shading alone, median"),
        ("/ Lambert", "that time over Lambert's"),
        ("frame, ms", "time of a whole frame"),
        ("L2 against the dipole", "relative error of the radiance against the hierarchical dipole's"),
        ("paper: head, fps", "frames per second of a head in the paper, on a GeForce 9300M GS"),
        ("paper: bunny, fps", "the same of a bunny"),
        ("paper: head, / Lambert", "the paper's time of the head over Lambert's"),
        ("paper: bunny, / Lambert", "the same of the bunny"),
    ];
    page.table("local-table-1", &Table::new(columns, rows))
}

/// sigma_0 of a material, as in figure 6.
fn fitted(bench: &Bench<'_>, page: &mut Page, preset: &Preset) -> Result<()> {
    page.head(&format!("Figure 6: sigma_0 of {} from balls in parallel light", preset.name));
    page.say("Lines: the function at the sigma_0 that pictures take, fitted to the dipole. Dots: the dipole.");
    page.say("Bars: a random walk and twice its standard error.");
    let channels = channels(preset, bench.device, None, (bench.either(3_000, 50_000), 0))?;
    let plot = |k: usize| svg(&format!("{}, balls", preset.name), &channels[k..=k]);
    page.plots(&(0..3).map(plot).collect::<Result<Vec<_>>>()?);
    let residual =
        "root mean square over a ball of what the fit misses, as a share of what a plane returns in full light";
    let digits = |x: f64| format!("{x:.4}");
    let table = Table::of(
        &channels.map(|channel| (channel.name, channel.fit())),
        &[
            ("channel", "", &|row| row.0.into()),
            ("sigma_0 by the dipole, mm", "the sigma_0 that fits the dipole best", &|row| digits(row.1[0].sigma_0)),
            ("residual of the dipole's fit", residual, &|row| digits(row.1[0].residual)),
            ("by the walk, mm", "the sigma_0 that fits a random walk best, times a factor", &|row| {
                digits(row.1[1].sigma_0)
            }),
            ("residual of the walk's fit", residual, &|row| digits(row.1[1].residual)),
            ("times", "that factor: how much more or less light the walk returns", &|row| {
                format!("{:.3}", row.1[1].scale)
            }),
        ],
    );
    page.table(&format!("sigma-0-{}", preset.name.to_lowercase()), &table)
}

/// Pictures by the dipole, the function and Lambert's cosine side by side, and the curvature.
fn compared(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("The dipole, the function, and Lambert's cosine");
    let side = bench.either(200, 360);
    let mut rows = Vec::new();
    for name in bench.either(&["bust"][..], &["bust", "lotus", "torus"]) {
        let scene = scene(name, [side; 2], coarser(bench))?;
        let dipole = Shot::take(&scene, bench.device, ShadingMethod::Hierarchy)?;
        let mut shown = vec![dipole.show(format!("{name}: dipole"))?];
        let mut row = vec![(*name).to_string(), format!("{:.1}", dipole.ms)];
        let mut flips = Vec::new();
        for (transport, called) in [(ShadingMethod::Cdrf, "CDRF"), (ShadingMethod::Lambert, "Lambert")] {
            let shot = Shot::take(&scene, bench.device, transport)?;
            let (mean, map) = shot.apart(&dipole)?;
            shown.extend([shot.show(called)?, map.show(format!("{called} against dipole, FLIP {mean:.3}"))?]);
            flips.push(mean);
            row.extend([format!("{:.1}", shot.ms), format!("{mean:.3}")]);
        }
        rows.push(row);

        let options = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
        let mut session = Session::new(&scene, bench.device, options)?;
        session.frame(Change::EVERYTHING)?;
        let (picture, found) = curvature_view(&mut session)?;
        let [low, high] = found.ends.map(|kappa| kappa / scene.unit_mm);
        let label = format!("{name}: curvature, blue {low:.2e} to red {high:.2e} per mm (figure 10a)");
        shown.push(Shot::of(&picture, f64::NAN).show(label)?);
        page.pictures(&shown);
        let (function, cosine) = (flips[0], flips[1]);
        let aim = format!("{name}: the CDRF is nearer to the dipole's picture than Lambert");
        page.find(Tone::of(function <= cosine), &aim, &format!("FLIP {function:.3} against {cosine:.3}"));
    }
    let columns = [
        ("scene", ""),
        ("dipole, ms", "time of the picture by the hierarchical dipole"),
        ("CDRF, ms", ""),
        ("CDRF, FLIP", "perceptual difference from the dipole's picture, 0 to 1"),
        ("Lambert, ms", ""),
        ("Lambert, FLIP", "perceptual difference from the dipole's picture, 0 to 1"),
    ];
    page.table("local", &Table::new(columns, rows))?;

    // A quick report leaves out the dipole's panels: they are slow, and the dipole is shown above.
    let side = bench.either(144, 360);
    let mut shown = Vec::new();
    for panel in panels([side; 2])?.into_iter().filter(|p| !bench.quick || p.transport != ShadingMethod::Hierarchy) {
        let scene = Scene { camera: Camera { samples: 1, ..panel.scene.camera.clone() }, ..panel.scene.clone() };
        shown.push(
            Shot::take(&scene, bench.device, panel.transport)?
                .show(format!("Figure {}: {}", panel.figure, panel.caption))?,
        );
    }
    page.head("Figures 1, 7, 9 and 11 with scenes of ours");
    page.say(
        "Figure 1: the larger sigma_0, the softer the shading where the surface bends most. Figure 7: a red rim beyond \
         the terminator, wider on the smaller ball. Figure 9: compared with the dipole, the function lacks light that \
         comes through thin parts (a quick report has the dipole's bust above). Figure 11: lit from behind, petals \
         glow where Lambert's are black; blue reaches farthest, since its sigma_0 is largest.",
    );
    page.pictures(&shown);
    Ok(())
}

/// Errors against the dipole, by thickness: where the function can be trusted.
fn trusted(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("How far the function can be trusted");
    page.say(
        "Error of the function's radiosity against the dipole's, per triangle and channel, by the object's thickness.",
    );
    let mut rows = Vec::new();
    for name in bench.either(&["bust"][..], &["bust", "lotus", "torus", "sphere"]) {
        let scene = scene(name, [1, 1], coarser(bench))?;
        let all = places(&scene, bench.device)?;
        page.plot(&svg_by_thickness(name, &all)?, false);
        let (error, words) = (share(&all, |_| true).error, verdict(&all));
        let aim = format!("{name}: the CDRF is within {:.0} % of the dipole", 100.0 * ASKED);
        page.find(Tone::of(error <= ASKED), &aim, &words);
        let plain = lambert_share(&all, |_| true).error;
        let nearer = format!("{name}: the CDRF is no farther from the dipole than Lambert");
        page.find(
            Tone::of(error <= plain),
            &nearer,
            &format!("L2 {:.1} % against {:.1} %", 100.0 * error, 100.0 * plain),
        );
        let row = [error, plain].map(|x| format!("{:.1}", 100.0 * x));
        rows.push([&[(*name).to_string()], &row[..], &[words]].concat());
    }
    let columns = [
        ("scene", ""),
        ("L2 error, %", "of the radiosity, against the dipole's"),
        ("Lambert's, %", "the same of Lambert's cosine"),
        ("verdict", "the parts of the surface where the function can be trusted"),
    ];
    page.table("validity", &Table::new(columns, rows))
}
