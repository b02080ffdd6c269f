//! The objects of a scene: the source of each mesh, its size, position and rotation, its material and its deformations.

use super::deform::{self, Deform, DeformFile};
use super::file::MaterialFile;
use super::files::Files;
use super::material::Material;
use super::mesh::{Coordinates, FORMATS, Mesh, Origin, Shape};
use super::play::Play;
use super::range::{self, Checked};
use super::texture::Texture;
use super::transport::{Hierarchy, Transport};
use super::vector::Vector;
use crate::error::Input;
use crate::phases::phase;
use glam::{DMat4, DQuat, DVec3, EulerRot};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A mesh with its material and deformations.
#[derive(Debug, Clone)]
pub struct Object {
    /// The surface in its own frame, in scene units.
    pub mesh: Mesh,
    /// Turns it from its own frame into the scene.
    pub rotation: DQuat,
    /// Where the origin of its own frame lies in the scene, scene units.
    pub position: DVec3,
    /// The material, with coefficients per scene unit.
    pub material: Material,
    /// The deformations, in order of application.
    pub deforms: Vec<Deform>,
}

impl Object {
    /// Where a point of its own frame lies in the scene.
    #[must_use]
    pub fn placed(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.position
    }

    /// The point of its own frame that lies there in the scene.
    #[must_use]
    pub fn unplaced(&self, point: DVec3) -> DVec3 {
        self.rotation.inverse() * (point - self.position)
    }

    /// The lowest and highest corner of its bounding box in the scene.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let both = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
        self.mesh
            .positions
            .iter()
            .map(|&p| self.placed(p))
            .map(|p| (p, p))
            .reduce(|all, p| both(all, p.0))
            .unwrap_or_default()
    }

    /// The corners of a triangle in the scene; `None` past the last one.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> Option<[DVec3; 3]> {
        Some(self.mesh.corners(triangle)?.map(|corner| self.placed(corner)))
    }
}

/// `[[object]]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectFile {
    mesh: Option<PathBuf>,
    part: Option<i64>,
    normals: Option<Normals>,
    shape: Option<Shape>,
    detail: Option<i64>,
    size: Option<f64>,
    position: Option<Vector>,
    rotation: Option<Vector>,
    #[serde(default)]
    deform: Vec<DeformFile>,
    #[serde(default)]
    material: MaterialFile,
}

/// The normals that a mesh is shaded with.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Normals {
    /// Those of its file, where it has some.
    File,
    /// Those of the triangles around each vertex.
    Faces,
}

/// A validated object whose mesh is not loaded yet.
#[derive(Debug)]
pub(super) struct Draft {
    source: Source,
    /// Whether it has the normals of its file.
    normals: bool,
    /// Largest extent to give the mesh, in scene units.
    size: Option<f64>,
    /// Rotation, applied before the position.
    rotation: DQuat,
    position: DVec3,
    /// Its material.
    pub material: Material,
    /// Its deformations.
    pub deforms: Vec<deform::Draft>,
}

/// Where a mesh comes from.
#[derive(Debug)]
pub(super) enum Source {
    /// A file, relative to the scene file, and the number of a part of it.
    File(PathBuf, Option<u32>),
    /// A built-in shape, and its detail.
    Shape(Shape, u32),
}

/// Maximum number of objects in a scene.
const MOST: usize = 256;

/// Checks the objects of a scene with units of `unit_mm` millimetres.
pub(super) fn check_all(files: &[ObjectFile], unit_mm: f64) -> Checked<Vec<Draft>> {
    if !(1..=MOST).contains(&files.len()) {
        let found = format!("{} times [[object]]", files.len());
        let what = if files.is_empty() { "there is nothing to show" } else { "too many objects" };
        return Err(Input::new(what).key("object").found(found).expected(format!("1 to {MOST} times [[object]]")));
    }
    files.iter().enumerate().map(|(index, file)| file.check(index, unit_mm)).collect()
}

impl ObjectFile {
    fn check(&self, index: usize, unit_mm: f64) -> Checked<Draft> {
        let key = |name: &str| format!("object.{index}.{name}");
        let size = self.size.map(|size| {
            let accept = |x| (1e-9..=range::LARGEST).contains(&x);
            range::number(&key("size"), size, accept, "1e-9 to 1e9 scene units")
        });
        let vector = |name: &str, value: Option<Vector>, most: f64, expected: &str| {
            let value = value.map_or([0.0; 3], |v| v.0);
            range::channels(&key(name), value, |x| x.abs() <= most, expected).map(DVec3::from_array)
        };
        let turn = vector("rotation", self.rotation, 36_000.0, "degrees about x, then y, then z, within 36000")?;
        let turn = turn.map(f64::to_radians);
        Ok(Draft {
            source: self.source(index)?,
            normals: self.normals != Some(Normals::Faces),
            size: size.transpose()?,
            rotation: DQuat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x),
            position: vector("position", self.position, range::LARGEST, "coordinates within 1e9 scene units")?,
            material: Material::check(&self.material, &key("material"), unit_mm)?,
            deforms: deform::check_all(&self.deform, &key("deform"))?,
        })
    }

    /// Exactly one of `mesh` and `shape`; `detail` only with the latter.
    fn source(&self, index: usize) -> Checked<Source> {
        let key = |name: &str| format!("object.{index}{name}");
        let accepted = "exactly one of `mesh` and `shape`";
        match (&self.mesh, self.shape) {
            (Some(_), Some(_)) => {
                let fault = Input::new("both a mesh and a shape are given");
                Err(fault.key(key(".shape")).expected(accepted))
            }
            (None, None) => {
                let fault = Input::new("neither a mesh nor a shape is given");
                Err(fault.key(key("")).expected(accepted))
            }
            (Some(_), None) if self.detail.is_some() => {
                let fault = Input::new("a mesh from a file has no such key");
                Err(fault
                    .key(key(".detail"))
                    .expected("mesh, part, normals, size, position, rotation, deform, material"))
            }
            (Some(path), None) if path.as_os_str().is_empty() => Err(Input::new("no file is named")
                .key(key(".mesh"))
                .found("\"\"")
                .expected(format!("a file in {FORMATS}"))),
            (Some(path), None) => {
                let number = |part: i64| {
                    let fault = Input::new("out of range").key(key(".part")).found(part);
                    u32::try_from(part).map_err(|_| fault.expected("a whole number from 0"))
                };
                Ok(Source::File(path.clone(), self.part.map(number).transpose()?))
            }
            (None, Some(_)) if self.part.is_some() => {
                let fault = Input::new("a shape has no parts").key(key(".part"));
                Err(fault.expected("shape, detail, size, position, rotation, deform, material"))
            }
            (None, Some(_)) if self.normals.is_some() => {
                let fault = Input::new("a shape has no file with normals").key(key(".normals"));
                Err(fault.expected("shape, detail, size, position, rotation, deform, material"))
            }
            (None, Some(shape)) => {
                let detail = self.detail.unwrap_or_else(|| i64::from(shape.usual_detail()));
                let range = shape.details();
                let accepted = u32::try_from(detail).ok().filter(|detail| range.contains(detail));
                let detail = accepted.ok_or_else(|| {
                    let expected = format!("{} to {}", range.start(), range.end());
                    let fault = Input::new("out of range").key(key(".detail"));
                    fault.found(detail).expected(expected)
                })?;
                Ok(Source::Shape(shape, detail))
            }
        }
    }
}

impl Draft {
    /// An upper bound on the triangles of its shape; 0 for a file.
    pub(super) fn most_triangles(&self) -> u64 {
        match self.source {
            Source::Shape(shape, detail) => shape.most_triangles(detail),
            Source::File(..) => 0,
        }
    }

    /// Its rotation and position in the scene. Deformations are laid out in the scene, so [`Self::mesh`] places an
    /// object that has any.
    pub(super) fn placement(&self) -> (DQuat, DVec3) {
        if self.deforms.is_empty() { (self.rotation, self.position) } else { Default::default() }
    }

    /// Whether nothing makes vertices anew, moves them, or goes along their edges, and knows nothing of the normals in
    /// a file.
    fn keeps_vertices(&self, transport: &Transport) -> bool {
        let plain = matches!(transport.hierarchy, Hierarchy::FaceClusters | Hierarchy::Median);
        plain && self.deforms.is_empty() && self.material.layers.is_none()
    }

    fn load_maps(&mut self, files: &Files, folder: &Path, index: usize, report: &mut Vec<String>) -> Checked<()> {
        let key = |name: &str| format!("object.{index}.material.{name}");
        if let Some(map) = &mut self.material.sigma_0_texture {
            map.load(files, folder, &self.source, &key("sigma_0_texture"), report)?;
        }
        if let Some(texture) = &mut self.material.texture {
            texture.load(files, folder, &self.source, &key("texture"), report)?;
        }
        if let Some(layers) = &mut self.material.layers {
            layers.load(files, folder, &key("layers"), report)?;
        }
        Ok(())
    }

    /// Loads textures and depth maps; reads or builds the mesh, refines it for the hierarchy and scales it, rotates and
    /// moves it if it has deformations; reads the targets of its morphs and the pose that
    /// `play` asks for. Paths are relative to `folder`.
    pub(super) fn mesh(
        &mut self,
        files: &Files,
        folder: &Path,
        index: usize,
        transport: &Transport,
        play: Option<&mut Play>,
        report: &mut Vec<String>,
    ) -> Checked<Mesh> {
        if let (Some(play), Source::File(path, part)) = (play, &self.source) {
            let played = deform::Draft::played(files, (&folder.join(path), *part), play)?;
            self.deforms.splice(..0, played);
        }
        let unwrapped = transport.unwrap && self.material.opaque.is_none();
        let textured = self.material.textured().map(|key| format!("object.{index}.material.{key}"));
        let textured = textured.or(unwrapped.then(|| "transport.unwrap".to_owned()));
        let own = self.material.texture.as_ref().is_some_and(Texture::is_own);
        self.load_maps(files, folder, index, report)?;
        let mesh = match &self.source {
            Source::File(path, part) => {
                let wanted = textured.as_deref().map(|key| Coordinates { key, own });
                let normals = self.normals && !unwrapped && self.keeps_vertices(transport);
                Mesh::read(files, &folder.join(path), *part, wanted, normals, report)?
            }
            Source::Shape(shape, detail) => {
                let most = shape.most_triangles(*detail);
                files.take(most * Mesh::BYTES).map_err(|error| {
                    let fault = Input::new("the shape does not fit the memory").key(format!("object.{index}.detail"));
                    fault.found(format!("{detail}, up to {most} triangles: {error}")).expected("fewer triangles")
                })?;
                phase("building shapes", || match textured {
                    Some(_) => shape.build_textured(*detail),
                    None => shape.build(*detail),
                })
            }
        };
        // No light enters an opaque object: it is not refined for the hierarchy.
        let (mut mesh, origin) = match self.material.opaque {
            None => mesh.refined(files, transport, report)?,
            Some(_) => (mesh, Origin::File),
        };
        mesh.detailed = matches!(self.source, Source::Shape(..));
        let mut unsaid = Vec::new();
        if let Some(layers) = &self.material.layers {
            // Built-in shapes are known to have triangles without area in the texture: do not report those.
            let shape = matches!(self.source, Source::Shape(..));
            layers.check_mesh(
                &mesh,
                &format!("object.{index}.material.layers"),
                if shape { &mut unsaid } else { report },
            )?;
        }
        let (middle, factor) = match self.size {
            Some(size) => mesh.resize(size, &format!("object.{index}.size"))?,
            None => (DVec3::ZERO, 1.0),
        };
        if !self.deforms.is_empty() {
            for position in &mut mesh.positions {
                *position = self.rotation * *position + self.position;
            }
        }
        let own = match &self.source {
            Source::File(path, part) => Some((path.as_path(), *part)),
            Source::Shape(..) => None,
        };
        for (number, deform) in self.deforms.iter_mut().enumerate() {
            let key = format!("object.{index}.deform.{number}.mesh");
            let placed = DMat4::from_scale_rotation_translation(DVec3::splat(factor), self.rotation, self.position);
            deform.load(files, folder, own, &origin, placed * DMat4::from_translation(-middle), &key)?;
        }
        Ok(mesh)
    }
}
