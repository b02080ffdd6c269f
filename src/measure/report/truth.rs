//! Section `truth`: how far each method is from the random walk, whatever its tolerance: the model's error and all
//! others, beside the time.

use super::pictures::Shot;
use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::truth::{Truth, TruthError};
use crate::measure::validity::places;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;

/// The shapes: their names, as scenes call them, cells for a full and a quick report, and a factor on the thickness.
const SHAPES: [(&str, &str, [u32; 2], f64); 3] = [
    ("ball, 20 mm", "sphere", [4, 3], 1.0),
    ("torus, 20 mm", "torus", [60, 36], 1.0),
    ("slab, 20 x 20 x 2 mm", "slab", [40, 24], 0.5),
];

/// All of them: 20 mm, under one light that shows two sides of the slab, and from where the camera sees both.
const COMMON: [&str; 4] = [
    "object.0.size=20",
    "light=[{ type = 'directional', direction = [0.5, 0.3, 0.8], irradiance = 3 }]",
    "camera.position=[-18, 14, 52]",
    "camera.fov=30",
];

/// The materials.
const MATERIALS: [&str; 3] = ["marble", "wholemilk", "skin1"];

/// What a method is called, its transport, and whether its picture is shown.
const METHODS: [(&str, ShadingMethod, bool); 3] = [
    ("dipole", ShadingMethod::Hierarchy, true),
    ("CDRF", ShadingMethod::Cdrf, true),
    ("Lambert", ShadingMethod::Lambert, false),
];

/// Radiosity of every triangle by a method, in the mesh's order, the picture and the milliseconds of a frame.
fn solved(scene: &Scene, bench: &Bench<'_>, method: ShadingMethod) -> Result<(Vec<[f64; 3]>, Shot)> {
    let mut session = Session::new(scene, bench.device, Options { transport: method, ..Options::default() })?;
    session.frame(Change::EVERYTHING)?;
    // The first frame makes lists and buffers; the next one is timed.
    let times = session.frame(Change::EVERYTHING)?;
    let shot = Shot::of(&session.picture()?, times.iter().map(|time| time.milliseconds).sum());
    if method == ShadingMethod::Hierarchy {
        return Ok((session.faces()?.into_iter().map(|face| face.radiosity).collect(), shot));
    }
    let mut found = vec![[0.0; 3]; scene.objects[0].mesh.triangles.len()];
    for place in places(scene, bench.device)? {
        let value = if method == ShadingMethod::Cdrf { place.cdrf } else { place.lambert };
        found[place.triangle as usize][place.channel] = value;
    }
    Ok((found, shot))
}

/// All shapes in all materials; a quick report has marble only, and walks of fewer photons.
pub fn truth(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    page.say(
        "The random walk (--transport walk) makes none of the models' approximations. Errors are relative L2 of the radiosity's \
         means over some 200 patches, with the walk's own noise taken off: what is left is the model's error, and no tolerance \
         makes it smaller. Times are those of a frame from scratch.",
    );
    let (side, mut rows, mut worst) = (bench.either(120, 240), Vec::new(), Vec::new());
    let effort = bench.either("transport.walks=12000", "transport.walk_error=0.04");
    for (shape, name, [full, quick], thinner) in SHAPES {
        for material in bench.either(&MATERIALS[..1], &MATERIALS[..]) {
            let own = [
                format!("camera.size=[{side}, {side}]"),
                "camera.samples=1".into(),
                format!("object.0.material={{ preset = '{material}' }}"),
                format!("object.0.shape={name}"),
                format!("object.0.detail={}", bench.either(quick, full)),
                effort.into(),
            ];
            let all = COMMON.iter().map(ToString::to_string).chain(own);
            let mut scene = Scene::load_with("sphere", &all.collect::<Vec<_>>())?;
            scene.objects[0].mesh.positions.iter_mut().for_each(|place| place.z *= thinner);
            let options = Options { transport: ShadingMethod::Walk, ..Options::default() };
            let mut session = Session::new(&scene, bench.device, options)?;
            session.frame(Change::EVERYTHING)?;
            let reference = Shot::of(&session.picture()?, f64::NAN);
            let (walk, report) = (Truth::of_session(&mut session)?, session.walk_reports()[0].clone());
            page.head(&format!("{shape}, {material}"));
            let mut shown = vec![reference.show(format!("random walk, {:.1} s", report.seconds))?];
            for (method, transport, pictured) in METHODS {
                let (found, shot) = solved(&scene, bench, transport)?;
                let TruthError { l2, noise } = walk.error(&found);
                let (flip, map) = shot.apart(&reference)?;
                if pictured {
                    shown.push(shot.show(format!("{method}, {:.1} ms", shot.ms))?);
                    shown.push(map.show(format!("difference, FLIP {flip:.3}"))?);
                }
                if transport == ShadingMethod::Hierarchy {
                    worst.push((l2.into_iter().fold(0.0, f64::max), shape, material));
                }
                let mut row = vec![shape.to_string(), (*material).to_string(), method.to_string()];
                row.extend(l2.map(|error| format!("{:.1}", 100.0 * error)));
                row.extend([format!("{flip:.3}"), format!("{:.1}", shot.ms)]);
                row.extend([format!("{:.1}", 100.0 * noise), report.photons.to_string()]);
                row.push(format!("{:.2}", report.seconds));
                rows.push(row);
            }
            page.pictures(&shown);
        }
    }
    let columns = [
        ("shape", ""),
        ("material", ""),
        ("method", ""),
        ("red %", "relative L2 error against the walk, the walk's noise taken off"),
        ("green %", "the same"),
        ("blue %", "the same"),
        ("FLIP", "perceptual difference of the pictures, 0 to 1; the walk's noise counts"),
        ("frame, ms", "a frame from scratch on the device"),
        ("walk's noise %", "relative L2 of the walk's standard errors over the same patches, worst channel"),
        ("photons", "of the walk, each channel"),
        ("walk, s", "time of the walk"),
    ];
    page.table("truth", &columns, &rows)?;
    for (error, shape, material) in worst {
        let aim = format!("{shape}, {material}: the dipole is within 5 % of a random walk");
        page.find(Tone::of(error <= 0.05), &aim, &format!("{:.0} %", 100.0 * error));
    }
    Ok(())
}
