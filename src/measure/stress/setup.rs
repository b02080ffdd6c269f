//! The scene of an extreme case: the base scene, changed as the file of cases says.

use glam::DVec3;
use serde::Deserialize;

use super::meshes::{both, cone, lines, mesh, reversed, sheet, turn, turned};
use crate::error::Result;
use crate::lighting::fresnel::transmittance;
use crate::scene::{Light, Mesh, Scene, Source};

/// The base scene: a marble ball, 1 mm across, in the sun.
const BASE: &str = r#"
unit = "mm"
[camera]
size = [24, 24]
[[light]]
type = "directional"
direction = [0.35, 0.6, 0.75]
irradiance = [1.0, 0.8, 0.6]
[[object]]
shape = "sphere"
detail = 2
size = 1
material = { sigma_s_prime = [22, 26, 30], sigma_a = [0.02, 0.04, 0.07], eta = 1.5 }
"#;

/// Changes of the base scene.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Setup {
    /// Settings, as `--set` takes them.
    pub set: Vec<String>,
    /// The mesh in place of the ball.
    mesh: Option<Shape>,
    /// The factor of all heights.
    height: Option<f64>,
    /// The direction towards the only light, of unit irradiance; it turns with the mesh.
    sun: Option<[f64; 3]>,
    /// Where objects, camera and lights are moved, mm.
    moved: [f64; 3],
    /// Whether the material becomes one-sided once the scene is checked: files may not have a light within a medium,
    /// which the base scene's ball would be.
    one_sided: bool,
    /// The expected radiosity.
    pub expect: Expected,
}

/// A mesh, built in code because import would reject some of them.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Shape {
    /// A sheet over [0,1]^2 that faces +z.
    Sheet {
        /// Cells along x and y.
        cells: [u32; 2],
        /// The distance of a second line after each inner one, in cells; 0 where there is none.
        #[serde(default)]
        doubled: [f64; 2],
        /// Whether it is rotated, so that no coordinate is a round number.
        #[serde(default)]
        turned: bool,
        /// The only triangle that faces the other way.
        #[serde(default)]
        flipped: Option<usize>,
        /// Further triangles: index in the list, vertices.
        #[serde(default)]
        inserted: Vec<(usize, [u32; 3])>,
        /// Whether a second sheet, which faces the other way, lies on the first one.
        #[serde(default)]
        twice: bool,
    },
    /// A rotated cone on a flat disc.
    Cone {
        /// Triangles around it.
        sides: u32,
        radius: f64,
        height: f64,
        /// Whether it counts as a mesh without open edges.
        #[serde(default)]
        closed: bool,
    },
    /// Balls of these sizes in units of the base scene's, and their places along x; below 0 the size of a hollow.
    Balls(Vec<[f64; 2]>),
}

/// The radiosity that a scene must have.
#[derive(Default, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Expected {
    /// That of the same scene in `f64`.
    #[default]
    Itself,
    /// That of another scene in `f64`, with the same faces in the same order, times a factor, and times the ratio of
    /// the light that enters where both have a `sun`.
    Another { scene: Box<Setup>, factor: f64 },
    /// Exactly zero.
    Darkness,
}

impl Setup {
    /// The scene, with further settings; its triangles stay as they are, however long.
    pub fn scene(&self, more: &[String]) -> Result<Scene> {
        let mut scene = Scene::parse("stress", BASE, &[&self.set, more].concat())?;
        scene.transport.divided = true;
        let object = &mut scene.objects[0];
        if let Some(shape) = &self.mesh {
            object.mesh = shape.mesh()?;
        }
        let (offset, height) = (DVec3::from_array(self.moved), self.height.unwrap_or(1.0));
        object.mesh.positions.iter_mut().for_each(|p| *p = *p * DVec3::new(1.0, 1.0, height) + offset);
        object.material.two_sided &= !self.one_sided;
        scene.camera.position += offset;
        scene.camera.target += offset;
        if let Some(sun) = self.sun.map(DVec3::from_array) {
            let is_turned = matches!(self.mesh, Some(Shape::Sheet { turned: true, .. }));
            scene.lights = vec![Light::directional(if is_turned { turn(sun) } else { sun }, [1.0; 3])];
        }
        for light in &mut scene.lights {
            if let Source::Point { position, .. } = &mut light.source {
                *position += offset;
            }
        }
        Ok(scene)
    }

    /// The ratio of the light that enters to that of another setup, per channel; 1 where one of them has no `sun`.
    pub fn entering(&self, other: &Self, eta: [f64; 3]) -> [f64; 3] {
        let Some((sun, other)) = self.sun.zip(other.sun) else { return [1.0; 3] };
        let entering = |eta: f64, cosine: f64| cosine * transmittance(eta, cosine);
        eta.map(|eta| entering(eta, sun[2]) / entering(eta, other[2]))
    }
}

impl Shape {
    fn mesh(&self) -> Result<Mesh> {
        Ok(match self {
            Self::Sheet { cells, doubled, turned: is_turned, flipped, inserted, twice } => {
                let mut flat = sheet(&lines(cells[0], doubled[0]), &lines(cells[1], doubled[1]));
                flipped.iter().for_each(|&triangle| flat.triangles[triangle].swap(1, 2));
                inserted.iter().for_each(|&(at, triangle)| flat.triangles.insert(at, triangle));
                let flat = mesh(flat.positions, flat.triangles);
                let flat = if *is_turned { turned(flat) } else { flat };
                if *twice { both(flat.clone(), reversed(flat)) } else { flat }
            }
            Self::Cone { sides, radius, height, closed } => {
                let cone = cone(*sides, *radius, *height);
                Mesh { open_edges: if *closed { 0 } else { cone.open_edges }, ..cone }
            }
            Self::Balls(balls) => {
                let ball = Setup::default().scene(&[])?.objects.swap_remove(0).mesh;
                let placed = balls.iter().map(|[size, place]| {
                    let mut ball = if *size < 0.0 { reversed(ball.clone()) } else { ball.clone() };
                    ball.positions.iter_mut().for_each(|p| *p = *p * size.abs() + DVec3::X * *place);
                    ball
                });
                Mesh { open_edges: 0, ..placed.reduce(both).unwrap_or_default() }
            }
        })
    }
}
