//! Kubo et al. 2010: the function itself, sigma_0 from balls, curvature, and how far it can be trusted.

use super::chart::{Axis, Line, chart};
use super::pictures::{Shot, scene};
use super::{Bench, Page, Tone};
use crate::dipole::profile::Dipole;
use crate::error::Result;
use crate::light::fresnel;
use crate::local::reflectance::cdrf;
use crate::measure::balls::fit::fit;
use crate::measure::balls::plot::{Panel, svg};
use crate::measure::balls::{dipole::curve as solve, walk::curve as walk};
use crate::measure::validity::{ASKED, Place, places, share, verdict};
use crate::measure::walk::Medium;
use crate::render::bends::bends;
use crate::render::local::spread;
use crate::render::plan::{Change, Options, Transport};
use crate::render::run::{Room, Session};
use crate::scene::{Camera, PRESETS, Preset, Tone as Curve};

/// Everything of this paper.
pub fn kubo(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    function(page)?;
    for name in bench.either(&["Skin1"][..], &["Skin1", "Marble", "Skimmilk"]) {
        fitted(bench, page, Preset::named(name).unwrap_or(&PRESETS[0]))?;
    }
    compared(bench, page)?;
    trusted(bench, page)
}

/// f over the angle, as in figure 4.
fn function(page: &mut Page) -> Result<()> {
    page.head("The curvature-dependent reflectance function");
    let curve = |sigma: f64| {
        let at = |degree: i32| (f64::from(degree), cdrf(f64::from(degree).to_radians().cos(), sigma));
        Line::new(format!("sigma {sigma}"), (0..=180).map(at))
    };
    page.plot(
        &chart(
            "f by the angle from the light",
            Axis { label: "angle, degrees", log: false },
            Axis { label: "f, no unit", log: false },
            &[0.0, 0.1, 0.25, 0.5, 1.0, 2.0].map(curve),
        )?,
        false,
    );
    Ok(())
}

/// sigma_0 of a material, as in figure 6.
fn fitted(bench: &Bench<'_>, page: &mut Page, preset: &Preset) -> Result<()> {
    page.head(&format!("sigma_0 of {} from balls in parallel light", preset.name));
    page.say(
        "Lines: the function at the sigma_0 fitted to the dipole; dots: the dipole; bars: a random walk and twice its standard \
         error. Residuals are root mean squares over a ball, of what leaves a plane in full light.",
    );
    let photons = bench.either(10_000, 100_000);
    let mean = [0, 1, 2].map(|c| 1.0 / (preset.sigma_s_prime[c] + preset.sigma_a[c])).iter().sum::<f64>() / 3.0;
    let radii = bench.either(&[2.0, 10.0, 50.0][..], &[2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
    let boundary = fresnel::boundary(fresnel::diffuse_internal_exact(preset.eta));
    let names = ["red", "green", "blue"];
    let (mut rows, mut found) = (Vec::new(), Vec::new());
    for (c, name) in names.iter().enumerate() {
        let (scattering, absorption) = (preset.sigma_s_prime[c], preset.sigma_a[c]);
        let dipole = Dipole::new(scattering, absorption, boundary);
        let medium = Medium { scattering, absorption, eta: preset.eta };
        let by_dipole: Vec<_> = radii.iter().map(|paths| solve(&dipole, paths * mean)).collect();
        let walked: Vec<_> =
            radii.iter().zip(1..).map(|(paths, k)| walk(medium, paths * mean, dipole.total(), photons, k)).collect();
        let (model, truth) = (fit(&by_dipole, spread(&dipole), false), fit(&walked, spread(&dipole), true));
        let mut row = vec![(*name).to_string()];
        row.extend([model.sigma_0, model.residual, truth.sigma_0, truth.residual].map(|x| format!("{x:.4}")));
        row.push(format!("{:.3}", truth.scale));
        rows.push(row);
        found.push((by_dipole, walked, model.sigma_0));
    }
    let panels: Vec<_> = found
        .iter()
        .zip(names)
        .map(|((dipole, walk, sigma_0), name)| Panel { name, dipole, walk, sigma_0: *sigma_0 })
        .collect();
    page.plot(&svg(&format!("{}: light that leaves balls", preset.name), &panels)?, true);
    let header = ["channel", "sigma_0 by the dipole, mm", "residual", "by the walk, mm", "residual", "times"];
    page.table(&format!("sigma-0-{}", preset.name.to_lowercase()), &header, &rows)
}

/// The dipole, the function and Lambert's cosine side by side; the curvature.
fn compared(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("The dipole, the function, and Lambert's cosine");
    let side = bench.either(200, 360);
    let mut rows = Vec::new();
    for name in bench.either(&["bust"][..], &["bust", "lotus", "torus"]) {
        let scene = scene(name, [side; 2], &[])?;
        let dipole = Shot::take(&scene, bench.device, Transport::Hierarchy)?;
        let mut shown = vec![dipole.show(format!("{name}: dipole"))?];
        let mut row = vec![(*name).to_string(), format!("{:.1}", dipole.ms)];
        for (transport, called) in [(Transport::Cdrf, "CDRF"), (Transport::Lambert, "Lambert")] {
            let shot = Shot::take(&scene, bench.device, transport)?;
            let (mean, map) = shot.apart(&dipole)?;
            shown.extend([shot.show(called)?, map.show(format!("{called} against dipole, FLIP {mean:.3}"))?]);
            row.extend([format!("{:.1}", shot.ms), format!("{mean:.3}")]);
        }
        page.pictures(&shown);
        rows.push(row);

        let options = Options { transport: Transport::Cdrf, ..Options::default() };
        let mut session = Session::new(&scene, bench.device, options, Room::default())?;
        session.frame(Change::EVERYTHING)?;
        let (picture, found) = bends(&mut session)?;
        let plain = Camera { exposure: 1.0, tone: Curve::default(), ..scene.camera.clone() };
        let [low, high] = found.ends.map(|kappa| kappa / scene.unit_mm);
        let label = format!("{name}: curvature, blue {low:.2e} to red {high:.2e} per mm (figure 10a)");
        page.pictures(&[Shot::of(&picture, &plain, f64::NAN).show(label)?]);
    }
    let header = ["scene", "dipole, ms", "CDRF, ms", "CDRF, FLIP", "Lambert, ms", "Lambert, FLIP"];
    page.table("local", &header, &rows)
}

/// Most dots of a plot.
const DOTS: usize = 2000;

/// The error against the dipole by thickness.
fn trusted(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.head("How far the function can be trusted");
    page.say("Radiosity by the function against the dipole's, triangle by triangle and channel by channel, by how thick the object is there.");
    let mut rows = Vec::new();
    for name in bench.either(&["bust"][..], &["bust", "lotus", "torus", "sphere"]) {
        let scene = scene(name, [1, 1], &[])?;
        let all = places(&scene, bench.device)?;
        let every = all.len().div_ceil(DOTS).max(1);
        let some: Vec<&Place> = all.iter().step_by(every).filter(|p| p.dipole > 0.0).collect();
        let part = |name: &str, low: f64, high: f64| {
            let own = some.iter().filter(|p| p.sigma >= low && p.sigma < high);
            let error = |p: &&&Place| 100.0 * ((p.cdrf - p.dipole) / p.dipole).clamp(-1.0, 2.0);
            Line::dots(name, own.map(|p| (p.thickness.clamp(0.1, 100.0), error(&p))).collect::<Vec<_>>())
        };
        let (x, y) =
            (Axis { label: "thickness / sigma_0", log: true }, Axis { label: "error, % of the dipole's", log: false });
        let classes =
            [part("sigma below 0.25", 0.0, 0.25), part("0.25 to 1", 0.25, 1.0), part("1 and more", 1.0, f64::INFINITY)];
        page.plot(&chart(&format!("{name}: error by thickness"), x, y, &classes)?, false);
        let (error, words) = (share(&all, |_| true).error, verdict(&all));
        page.find(if error <= ASKED { Tone::Win } else { Tone::Loss }, &format!("CDRF on {name}: {words}"));
        rows.push(vec![(*name).to_string(), format!("{:.1}", 100.0 * error), words]);
    }
    page.table("validity", &["scene", "L2 error, %", "verdict"], &rows)
}
