//! The program's own transport methods as solvers: a session, frame after frame; diffusion, with lights that turn.

use glam::DMat3;

use super::method::change;
use super::{Bench, Lighting, Opened, Solver, diffusion_at};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::links::links;
use crate::pipeline::plan::{Change, Mode, Options, ShadingMethod};
use crate::scene::{Light, Scene, Source};
use crate::session::choice::closed;
use crate::session::run::Session;

/// A session, and the change before each frame.
pub(super) struct Frames {
    session: Session,
    change: Change,
}

impl Frames {
    /// Opens a session and runs its first frame; `change` applies to every later one.
    pub(super) fn open(scene: &Scene, device: Option<&Device>, options: Options, change: Change) -> Result<Opened> {
        let mut session = Session::new(scene, device, options)?;
        match session.frame(Change::EVERYTHING) {
            Err(Error::TooMuchToKeep { what, .. }) => Ok(Opened::NotOffered(format!("too much to keep: {what}"))),
            Err(error) => Err(error),
            Ok(_) => Ok(match session.not_kept() {
                Some(why) => Opened::NotOffered(format!("too much to keep: {why}")),
                None => Opened::Ready(Box::new(Self { session, change })),
            }),
        }
    }
}

impl Solver for Frames {
    fn frame(&mut self) -> Result<Option<f64>> {
        let milliseconds = self.session.frame(self.change)?.iter().map(|part| part.milliseconds).sum::<f64>();
        let on_device =
            self.session.device().is_some() && self.session.plan().options().transport != ShadingMethod::Octree;
        let timed = on_device && milliseconds.is_finite();
        Ok(timed.then_some(milliseconds))
    }

    fn light(&mut self, lights: &[Light]) -> Result<()> {
        self.session.set_lights(lights)
    }

    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>> {
        self.session.fetch(&[BufferId::radiosity])?;
        let light = self.session.units().light;
        let radiosity = &self.session.state().data.radiosity;
        let places = self.session.prepared().all_places();
        Ok(places.map(|place| radiosity[place].map(|x| f64::from(x) * light)).collect())
    }

    fn links_per_face(&mut self) -> Result<Option<f64>> {
        let faces = self.session.state().sum(|object| object.count.faces) as f64;
        Ok(links(&mut self.session)?.map(|links| links as f64 / faces))
    }
}

/// Opens diffusion that starts from 0 in each frame.
pub(super) fn diffusion(bench: &Bench<'_>, lighting: Lighting, tolerance: f64) -> Result<Opened> {
    if let Err(why) = closed(bench.scene) {
        return Ok(Opened::NotOffered(why.to_string()));
    }
    let (scene, options) = diffusion_at(bench.scene, tolerance);
    Frames::open(&scene, bench.device, options, change(lighting))
}

/// Opens diffusion that starts from the last frame's solution.
pub(super) fn diffusion_kept(bench: &Bench<'_>, lighting: Lighting, tolerance: f64) -> Result<Opened> {
    let turned = turned(&bench.scene.lights, 3.0);
    if lighting == Lighting::Rests || turned == bench.scene.lights {
        return Ok(Opened::NotOffered("for lights that turn".into()));
    }
    if let Err(why) = closed(bench.scene) {
        return Ok(Opened::NotOffered(why.to_string()));
    }
    let (scene, options) = diffusion_at(bench.scene, tolerance);
    let options = Options { mode: Mode::Render, ..options };
    Ok(match Frames::open(&scene, bench.device, options, Change::LIGHT)? {
        Opened::Ready(frames) => Opened::Ready(Box::new(Turning { frames, lights: [turned, scene.lights.clone()] })),
        not => not,
    })
}

/// A method whose lights turn to and fro; only the way back is timed, so that errors belong to the scene's own lights.
struct Turning {
    /// The method.
    frames: Box<dyn Solver>,
    /// The turned lights, and the scene's own.
    lights: [Vec<Light>; 2],
}

impl Solver for Turning {
    fn before(&mut self) -> Result<()> {
        self.frames.light(&self.lights[0])?;
        self.frames.frame()?;
        self.frames.light(&self.lights[1])
    }

    fn frame(&mut self) -> Result<Option<f64>> {
        self.frames.frame()
    }

    fn light(&mut self, lights: &[Light]) -> Result<()> {
        self.frames.light(lights)
    }

    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>> {
        self.frames.radiosity()
    }

    fn links_per_face(&mut self) -> Result<Option<f64>> {
        self.frames.links_per_face()
    }
}

/// Lights turned about the scene's y axis, by degrees.
fn turned(lights: &[Light], degrees: f64) -> Vec<Light> {
    let turn = DMat3::from_rotation_y(degrees.to_radians());
    let mut lights = lights.to_vec();
    for light in &mut lights {
        match &mut light.source {
            Source::Directional { direction, .. } => *direction = turn * *direction,
            Source::Point { position, .. } => *position = turn * *position,
            Source::Spot { position, direction, .. } => {
                (*position, *direction) = (turn * *position, turn * *direction);
            }
            Source::Area { position, edge_u, edge_v, .. } => {
                (*position, *edge_u, *edge_v) = (turn * *position, turn * *edge_u, turn * *edge_v);
            }
            Source::Environment { sky, .. } => sky.rotation += degrees,
        }
    }
    lights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::pareto::{METHODS, Yardstick};

    #[test]
    fn every_light_turns() {
        let sets = [
            "light.1={ type='point', position=[10, 20, 30], intensity=1 }",
            "light.2={ type='spot', position=[10, 20, 30], direction=[0, 0, 1], intensity=1, outer=20 }",
            "light.3={ type='area', position=[50, 40, 20], edge_u=[2, 0, 3], edge_v=[0, 2, 2], radiance=2 }",
            "light.4={ type='environment', image='builtin:sky' }",
        ];
        let lights = Scene::load_with("sphere", &sets.map(String::from)).unwrap().lights;
        assert!(lights.iter().zip(&turned(&lights, 3.0)).all(|(light, turned)| light != turned));
        let Source::Point { position, .. } = turned(&lights, 90.0)[1].source else { panic!("no point light") };
        assert!((position - glam::DVec3::new(30.0, 20.0, -10.0)).length() < 1e-12, "{position}");
    }

    #[test]
    fn errors_are_those_at_the_scene_s_own_lights() {
        let sets = ["object.0.detail=2".to_string(), "transport.tolerance=1e-2".to_string()];
        let scene = Scene::load_with("sphere", &sets).unwrap();
        let bench = Bench { scene: &scene, device: None };
        let yardstick = Yardstick::new(&scene, 60, 1).unwrap().with_diffusion(&scene, Some(1e-3)).unwrap();
        for method in METHODS.iter().filter(|method| method.name.starts_with("diffusion")) {
            let Opened::Ready(mut solver) = (method.open)(&bench, Lighting::Moves, 1e-3).unwrap() else { panic!() };
            for _ in 0..2 {
                solver.before().unwrap();
                solver.frame().unwrap();
                let [own, total] = yardstick.errors(method, &solver.radiosity().unwrap());
                assert!(own.l2 > 0.0 && own.l2 < 1e-3 && total.l2.is_nan(), "{}: {own:?} {total:?}", method.name);
            }
        }
        // The errors that there would be if the lights did not turn back.
        let mut elsewhere = scene.clone();
        elsewhere.lights = turned(&scene.lights, 3.0);
        let Opened::Ready(mut solver) =
            diffusion(&Bench { scene: &elsewhere, ..bench }, Lighting::Moves, 1e-3).unwrap()
        else {
            panic!()
        };
        let diffusion = METHODS.iter().find(|method| method.name == "diffusion").unwrap();
        assert!(yardstick.errors(diffusion, &solver.radiosity().unwrap())[0].l2 > 1e-2);
    }

    #[test]
    fn an_open_mesh_is_not_offered() {
        let mut scene = Scene::load_with("sphere", &["object.0.detail=1".to_string()]).unwrap();
        scene.objects[0].mesh.open_edges = 3;
        let bench = Bench { scene: &scene, device: None };
        for open in [diffusion, diffusion_kept] {
            let Opened::NotOffered(why) = open(&bench, Lighting::Moves, 1e-1).unwrap() else { panic!("offered") };
            assert!(why.contains("3 open edges"), "{why}");
        }
    }
}
