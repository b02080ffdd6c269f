//! Cost and error of shading by curvature compared with Lambert's cosine, and the results of its paper: table 1 and
//! figures 1, 2, 4, 7, 9 and 11 of Kubo et al. 2010 as rows and scenes. Figure 6 is in [`crate::measure::balls`], the
//! limits of the method in [`crate::measure::validity`].

use crate::error::{Error, Input, Result};
use crate::gpu::Device;
use crate::layers::{plane_fit, relief};
use crate::layout::BufferId;
use crate::measure::statistics::median;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::prepare::shading::sigma_0;
use crate::scene::{Cdrf, Receivers, Scene, Surface};
use crate::session::run::Session;
use crate::shading::reflectance;
use crate::shading::{
    bake_irradiance, blur, cdrf, curvature, curvature_sums, lambert, pack_normals, smooth_curvature, texture_blur,
};
use crate::state::{Stage, wide};
use crate::view::{backdrop, reflect, shade, texture_out, visibility};

/// One shading technique.
#[derive(Clone, Debug)]
pub struct Row {
    /// The technique's name in the paper's table.
    pub technique: &'static str,
    /// Milliseconds of the technique's own stages for a new light, without visibility and shadows: the median.
    pub shading: f64,
    /// Ratio to Lambert's time in the same round: the median.
    pub ratio: f64,
    /// Milliseconds of one frame with a new view and a new light.
    pub frame: f64,
    /// Relative L2 of the radiance against the hierarchical dipole's, over the pixels that show translucent objects.
    pub error: f64,
}

/// Frames per second in the paper's table 1, on a GeForce 9300M GS at 512 x 512: technique, human head (20,154
/// vertices), bunny (48,903).
pub const PAPER: [(&str, f64, f64); 4] = [
    ("Lambert", 575.2, 693.2),
    ("texture blur", 41.5, 35.3),
    ("CDRF, closed form", 133.2, 110.9),
    ("CDRF, table", 492.1, 482.6),
];

/// The stages counted as a technique's own cost.
const OWN: [&Stage; 5] = [&lambert::STAGE, &cdrf::STAGE, &bake_irradiance::STAGE, &blur::STAGE, &texture_blur::STAGE];

/// The stages that turn radiosity into a picture.
const SEEN: [&Stage; 7] = [
    &visibility::STAGE,
    &shade::STAGE,
    &texture_out::STAGE,
    &reflect::STAGE,
    &backdrop::STAGE,
    &plane_fit::STAGE,
    &relief::STAGE,
];

/// One round in this many includes the texture blur, which takes about a hundred times as long as the others.
const BLURS: usize = 20;

/// The paper's techniques on a scene, in the order of its table. They are timed alternately over `frames` rounds, so
/// that other load on the machine affects all alike; the texture blur in fewer rounds. The texture blur is left out
/// without one-to-one texture coordinates (`transport.unwrap`).
pub fn table_1(scene: &Scene, device: Option<&Device>, frames: usize) -> Result<Vec<Row>> {
    let scene = &bare(scene);
    let carried = picture(scene, device, Options::default())?;
    let techniques = [
        (PAPER[0].0, ShadingMethod::Lambert, Cdrf::Closed),
        (PAPER[1].0, ShadingMethod::TextureBlur, Cdrf::Closed),
        (PAPER[2].0, ShadingMethod::Cdrf, Cdrf::Closed),
        (PAPER[3].0, ShadingMethod::Cdrf, Cdrf::Table),
    ];
    let (mut sessions, mut errors) = (Vec::new(), Vec::new());
    for (name, transport, cdrf) in techniques {
        let mut scene = scene.clone();
        scene.transport.cdrf = cdrf;
        let options = Options { transport, ..Options::default() };
        let mut session = match Session::new(&scene, device, options) {
            // No texture coordinates, or overlapping ones.
            Err(Error::Input(_)) if transport == ShadingMethod::TextureBlur => continue,
            session => session?,
        };
        session.frame(Change::EVERYTHING)?;
        errors.push(error(&mut session, &carried)?);
        sessions.push((name, session));
    }
    let mut times = vec![Vec::new(); sessions.len()];
    for turn in 0..frames.max(1) {
        // Lambert's time comes first in each round.
        let mut lambert = f64::NAN;
        for ((name, session), times) in sessions.iter_mut().zip(&mut times) {
            if *name == PAPER[1].0 && turn % BLURS != 0 {
                continue;
            }
            let steps = session.frame(Change::LIGHT)?;
            let own = steps.iter().filter(|step| OWN.iter().any(|stage| stage.name == step.name));
            let own: f64 = own.map(|step| step.milliseconds).sum();
            lambert = if *name == PAPER[0].0 { own } else { lambert };
            times.push([own, own / lambert]);
        }
    }
    let mut wholes = Vec::new();
    for (_, session) in &mut sessions {
        let steps = session.frame(Change::VIEW.and(Change::LIGHT))?;
        wholes.push(steps.iter().map(|step| step.milliseconds).sum::<f64>());
    }
    let middle = |k: usize, column: usize| median(times[k].iter().map(|time| time[column]).collect());
    let row = |(k, (technique, _)): (usize, &(&'static str, Session))| Row {
        technique,
        shading: middle(k, 0),
        ratio: middle(k, 1),
        frame: wholes[k],
        error: errors[k],
    };
    Ok(sessions.iter().enumerate().map(row).collect())
}

/// The scene without surface reflections, one sample per pixel.
fn bare(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera.samples = 1;
    scene.objects.iter_mut().for_each(|object| object.material.surface = Surface::default());
    scene
}

/// Renders a scene.
fn picture(scene: &Scene, device: Option<&Device>, options: Options) -> Result<Vec<[f32; 3]>> {
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    Ok(session.picture()?.pixels)
}

/// Relative L2 of a session's picture against another one over the pixels that show translucent objects; 0 if none
/// do.
fn error(session: &mut Session, other: &[[f32; 3]]) -> Result<f64> {
    let own = session.picture()?.pixels;
    let seen = shown(session)?;
    let (mut apart, mut whole) = (0.0, 0.0);
    for ((own, other), _) in own.iter().zip(other).zip(&seen).filter(|(_, seen)| **seen) {
        apart += (wide(*own) - wide(*other)).length_squared();
        whole += wide(*other).length_squared();
    }
    Ok(if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 })
}

/// How much of a picture is small detail: the root mean square of what a pixel has beyond the mean of the square of
/// `2 reach + 1` pixels about it, over the mean pixel; of the squares that show translucent objects only. Sums of
/// channels; 0 if there is no such square.
pub fn detail(session: &mut Session, reach: usize) -> Result<f64> {
    let picture = session.picture()?;
    let shows = shown(session)?;
    let light: Vec<f64> = picture.pixels.iter().map(|pixel| pixel.iter().map(|x| f64::from(*x)).sum()).collect();
    let (mut apart, mut whole, mut count) = (0.0, 0.0, 0.0);
    for y in reach..picture.height.saturating_sub(reach) {
        for x in reach..picture.width.saturating_sub(reach) {
            let rows = y - reach..=y + reach;
            let near = || rows.clone().flat_map(|y| (x - reach..=x + reach).map(move |x| y * picture.width + x));
            if near().all(|at| shows[at]) {
                let middle = light[y * picture.width + x];
                let mean = near().map(|at| light[at]).sum::<f64>() / (2 * reach + 1).pow(2) as f64;
                apart += (middle - mean).powi(2);
                whole += middle;
                count += 1.0;
            }
        }
    }
    Ok(if whole > 0.0 { (apart * count).sqrt() / whole } else { 0.0 })
}

/// Which pixels show translucent objects.
fn shown(session: &mut Session) -> Result<Vec<bool>> {
    session.fetch(&[BufferId::hits])?;
    let state = session.state();
    let shows = |face: u32| {
        let known = (face as usize) < state.data.triangles.len();
        known && !state.objects[state.object_of(face as usize)].opaque
    };
    Ok(state.data.hits.iter().map(|hit| shows(hit.face)).collect())
}

/// Cost of curvature when the shape changes in every frame.
#[derive(Clone, Copy, Debug)]
pub struct Bending {
    /// Vertices of all objects.
    pub vertices: usize,
    /// Milliseconds of computing, smoothing and packing curvature: the median.
    pub curvature: f64,
    /// Milliseconds of a hierarchical solve for the radiosity of every triangle, from scratch: the median.
    pub solve: f64,
}

/// Times curvature against a hierarchical solve, over `frames` frames each.
pub fn bending(scene: &Scene, device: Option<&Device>, frames: usize) -> Result<Bending> {
    let mut scene = scene.clone();
    // Rendering is not timed, so a small picture will do.
    (scene.camera.size, scene.transport.receivers) = ([64, 64], Receivers::Faces);
    let session = |transport: ShadingMethod| {
        let mut session = Session::new(&scene, device, Options { transport, ..Options::default() })?;
        session.frame(Change::EVERYTHING).map(|_| session)
    };
    let (mut local, mut carried) = (session(ShadingMethod::Cdrf)?, session(ShadingMethod::Hierarchy)?);
    let (mut bends, mut solves) = (Vec::new(), Vec::new());
    for _ in 0..frames.max(1) {
        let sum = |session: &mut Session, counts: &dyn Fn(&str) -> bool| -> Result<f64> {
            let steps = session.frame(Change::EVERYTHING)?;
            Ok(steps.iter().filter(|step| counts(&step.name)).map(|step| step.milliseconds).sum())
        };
        bends.push(sum(&mut local, &|name| {
            let own = [&curvature::STAGE, &curvature_sums::STAGE, &smooth_curvature::STAGE, &pack_normals::STAGE];
            own.iter().any(|stage| stage.name == name)
        })?);
        // The solve's time excludes the stages that make a picture.
        let seen = |name: &str| SEEN.iter().any(|stage| stage.name == name);
        solves.push(sum(&mut carried, &|name| !seen(name))?);
    }
    let vertices = local.state().sum(|object| object.count.vertices);
    Ok(Bending { vertices, curvature: median(bends), solve: median(solves) })
}

/// f over the angle from the light (figures 4 and 8): `count` pairs, at least two, of an angle from 0 to 180 degrees
/// and f, for a sigma of at least 0, radian.
#[must_use]
pub fn curve(sigma: f64, count: usize) -> Vec<[f64; 2]> {
    let degrees = |k: usize| 180.0 * k as f64 / (count.max(2) - 1) as f64;
    (0..count.max(2)).map(|k| [degrees(k), reflectance::cdrf(degrees(k).to_radians().cos(), sigma)]).collect()
}

/// A ball of a scene's material in parallel light (figure 7).
#[derive(Clone, Debug)]
pub struct Ball {
    /// Its radius, mm.
    pub radius: f64,
    /// sigma_0 / radius, per channel.
    pub sigma: [f64; 3],
    /// Angle from the light in degrees, and f of each channel.
    pub curve: Vec<[f64; 4]>,
}

/// Balls of these radii, mm, of the material of the scene's first object, at `count` angles each; an error if it is
/// opaque.
pub fn balls(scene: &Scene, radii: &[f64], count: usize) -> Result<Vec<Ball>> {
    let material = &scene.objects[0].material;
    if material.opaque.is_some() {
        return Err(Input::new("no light enters the material").expected("scattering and absorption").into());
    }
    let sigma_0 = sigma_0(material).map(|length| length * scene.unit_mm);
    let ball = |&radius: &f64| {
        let sigma = sigma_0.map(|length| length / radius);
        let [r, g, b] = sigma.map(|sigma| curve(sigma, count));
        let all = r.iter().zip(&g).zip(&b).map(|((r, g), b)| [r[0], r[1], g[1], b[1]]).collect();
        Ball { radius, sigma, curve: all }
    };
    Ok(radii.iter().map(ball).collect())
}

/// One picture of a figure, made with our scenes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The paper's figure.
    pub figure: u32,
    /// Its caption.
    pub caption: String,
    /// The scene.
    pub scene: Scene,
    /// The shading method.
    pub transport: ShadingMethod,
}

/// Figures 1, 7, 9 and 11: the bust at increasing sigma_0; balls of skin without and with scattering; the bust by the
/// CDRF and by the dipole; the lotus without and with scattering, lit from the front and from behind. The numbers for
/// figure 9 come from [`crate::measure::validity::places`].
pub fn panels(size: [u32; 2]) -> Result<Vec<Panel>> {
    let mut all = Vec::new();
    let mut add = |figure: u32, caption: &str, name: &str, sets: &[&str], transport: ShadingMethod| -> Result<()> {
        let mut sets: Vec<String> = sets.iter().map(|set| (*set).to_string()).collect();
        sets.push(format!("camera.size=[{}, {}]", size[0], size[1]));
        all.push(Panel { figure, caption: caption.into(), scene: Scene::load_with(name, &sets)?, transport });
        Ok(())
    };
    add(1, "Lambert", "bust", &[], ShadingMethod::Lambert)?;
    for [r, g, b] in [[0.5, 0.4, 0.3], [2.0, 1.6, 1.2], [6.0, 4.8, 3.6]] {
        let sigma = format!("object.0.material.sigma_0=[{r}, {g}, {b}]");
        add(1, &format!("sigma_0 = {r}, {g}, {b} mm"), "bust", &[&sigma], ShadingMethod::Cdrf)?;
    }
    let skin = "object.0.material.preset=skin1";
    add(7, "Lambert", "sphere", &[skin, "object.0.size=40"], ShadingMethod::Lambert)?;
    for radius in [20, 5] {
        let ball = format!("object.0.size={}", 2 * radius);
        add(7, &format!("radius {radius} mm"), "sphere", &[skin, &ball], ShadingMethod::Cdrf)?;
    }
    add(9, "CDRF", "bust", &[], ShadingMethod::Cdrf)?;
    add(9, "hierarchical dipole", "bust", &[], ShadingMethod::Hierarchy)?;
    for (side, light) in [("front", "light.0.position=[20, 40, 60]"), ("behind", "light.0.position=[-20, 30, -60]")] {
        let light = [light, "light.0.intensity=[6000, 6000, 6000]", "light.0.shadows=false"];
        let sigma = "object.0.material.sigma_0=[0.9, 1.3, 2.3]";
        add(11, &format!("from {side}, Lambert"), "lotus", &light, ShadingMethod::Lambert)?;
        add(11, &format!("from {side}, CDRF"), "lotus", &[&light[..], &[sigma]].concat(), ShadingMethod::Cdrf)?;
    }
    Ok(all)
}
