//! The studio around a mesh alone: a scene whose picture shows translucency. A weak key light and a soft fill in front,
//! a strong light behind that shines through thin parts, a grey backdrop, a glossy surface, and a camera that sees the
//! broad side of what stands upright.

mod depth;
mod lights;
mod pose;
mod sheet;

pub use pose::{Up, ViewFrom};

use super::light::Sky;
use super::range::Checked;
use super::text::Text;
use super::{BUILTIN, Files, Preset, Scene, around, locate, read};
use crate::error::{Input, Result};
use glam::{DQuat, DVec3};
use lights::Backdrop;
use pose::{Pose, is_gltf};
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use toml::{Table, Value};

/// The user's choices in place of the studio's.
#[derive(Debug, Clone, Default)]
pub struct Wishes {
    /// The material's name among the presets.
    pub preset: Option<String>,
    /// Largest extent, mm.
    pub size_mm: Option<f64>,
    /// Samples per pixel, 1 to 64.
    pub samples: Option<u32>,
    /// Width and height of the picture, pixels.
    pub pixels: Option<[u32; 2]>,
    /// The axis of the mesh that points upwards.
    pub up: Option<Up>,
    /// Where the camera stands.
    pub view: Option<ViewFrom>,
    /// Whether the object stands on a table.
    pub ground: bool,
    /// An image of the surroundings, `.exr` or `.hdr`.
    pub environment: Option<String>,
}

/// The default extent of a mesh of skin, mm. Red light passes through 20 mm of it as through a lampshade.
const SKIN: f64 = 40.0;

impl Wishes {
    /// Returns an error for an unknown preset, a size out of range, or a camera below the table.
    fn check(&self) -> Checked<()> {
        if let Some(name) = self.preset.as_deref().filter(|name| Preset::named(name).is_none()) {
            let names = Preset::names();
            let what = locate::with_suggestion("unknown preset", name, &names);
            return Err(Input::new(what).key("--preset").found(name).expected(names.join(", ").to_lowercase()));
        }
        self.view.map_or(Ok(()), |view| view.stands(self.ground))?;
        match self.size_mm.filter(|size| !(1e-6..=1e6).contains(size)) {
            Some(size) => {
                let fault = Input::new("not a size").key("--size-mm").found(size);
                Err(fault.expected("the largest extent in mm, 1e-6 to 1e6"))
            }
            None => Ok(()),
        }
    }
}

/// A mesh alone in its studio.
#[derive(Debug)]
pub struct Studio {
    text: Text,
    /// The scene without lights, camera and table.
    table: Table,
    pose: Pose,
    backdrop: Backdrop,
    /// Whether all translucent objects are sheets without thickness.
    thin: bool,
    wishes: Wishes,
    /// What was assumed, and what shows more, one per entry.
    pub told: Vec<String>,
}

/// The text of the scene of a mesh alone; none for a built-in scene or a scene file.
fn mesh_alone(name_or_path: &str, files: &Files) -> Checked<Option<Text>> {
    if BUILTIN.iter().any(|(name, ..)| name.eq_ignore_ascii_case(name_or_path)) {
        return Ok(None);
    }
    Ok(Some(Text::find(name_or_path, files)?).filter(|text| text.alone))
}

impl Studio {
    /// Builds the studio for the mesh in a file as it is at `frame`; `None` for a scene file or a built-in scene. Of
    /// the settings, those of objects, of `unit` and of the camera's lens decide where lights and camera stand.
    pub fn around(
        name_or_path: &str,
        sets: &[String],
        frame: f64,
        files: &Files,
        wishes: Wishes,
    ) -> Result<Option<Self>> {
        let Some(text) = mesh_alone(name_or_path, files)? else { return Ok(None) };
        Self::of(text, sets, frame, files, wishes).map(Some)
    }

    /// Builds the studio for a built-in shape, by its name.
    pub fn around_shape(shape: &str, files: &Files, wishes: Wishes) -> Result<Self> {
        let toml = around(&format!("shape = {}", Value::String(shape.to_owned())));
        let (name, file, folder) = (shape.to_owned(), shape.into(), Default::default());
        Self::of(Text { name, toml, file, folder, alone: true, report: Vec::new() }, &[], 0.0, files, wishes)
    }

    fn of(text: Text, sets: &[String], frame: f64, files: &Files, wishes: Wishes) -> Result<Self> {
        wishes.check()?;
        let shaping = ["object.", "unit", "animation", "fps", "camera.fov", "camera.size"];
        let sets: Vec<String> =
            sets.iter().filter(|set| shaping.iter().any(|key| set.trim_start().starts_with(key))).cloned().collect();
        let mut table: Table = toml::from_str(&text.toml).unwrap_or_default();
        let ask = |key: &str, value: &Value, table: &mut Table| {
            let camera = table.entry("camera").or_insert_with(|| Table::new().into());
            if let Value::Table(camera) = camera {
                camera.entry(key).or_insert_with(|| value.clone());
            }
        };
        ask("fov", &Value::Float(30.0), &mut table);
        if let Some(size) = wishes.pixels {
            ask("size", &Value::Array(size.map(|n| Value::Integer(n.into())).to_vec()), &mut table);
        }
        look(&mut table, wishes.preset.as_deref());
        let mut as_it_is = scene_of(&text, &table, &sets, frame, files)?;
        if let Some(size) = size_mm(&wishes, &sets, &text.file)? {
            let (low, high) = as_it_is.bounds();
            let factor = size / ((high - low).max_element() * as_it_is.unit_mm).max(1e-12);
            objects(&mut table, |object| enlarge(object, factor));
            for object in &mut as_it_is.objects {
                object.mesh.positions.iter_mut().for_each(|position| *position *= factor);
                object.position *= factor;
            }
        }

        // Upright: unless the user has turned it.
        let turned = sets.iter().any(|set| set.contains(".rotation"));
        let up = wishes.up.unwrap_or_else(|| if turned { Up::Y } else { Up::guess(&text.file, &as_it_is) });
        if up == Up::Z && !turned {
            objects(&mut table, lay);
            let upright = DQuat::from_rotation_x(-FRAC_PI_2);
            for object in &mut as_it_is.objects {
                (object.rotation, object.position) = (upright * object.rotation, upright * object.position);
            }
        }
        let own_lights = table.get("light") != toml::from_str::<Table>(&around("")).unwrap_or_default().get("light");
        let given = [table.get("camera").is_some_and(|c| c.get("position").is_some()), is_gltf(&text.file)];
        let pose = Pose::of(&as_it_is, wishes.ground, given, wishes.view);
        let backdrop = Backdrop::of(wishes.environment.as_deref(), own_lights, files)?;
        let sheets = sheet::all(&as_it_is);
        let mut told = depth::told(&as_it_is, &sheets, &text.name, up, wishes.up.is_none() && !turned, &backdrop);
        // Sheets have no inside: light enters from both sides, unless the user says otherwise.
        let set_by_user = |number: &usize| {
            let material = format!("object.{number}.material");
            let whole =
                |set: &String| set.trim_start().strip_prefix(&material).is_some_and(|rest| !rest.starts_with('.'));
            sets.iter().any(|set| whole(set) || set.contains(&format!("{material}.two_sided")))
        };
        let lit: Vec<usize> = sheets.iter().copied().filter(|number| !set_by_user(number)).collect();
        if !lit.is_empty() {
            told.push(both_sides(&mut table, &lit, as_it_is.objects.len(), &text.name));
        }
        let translucent = as_it_is.objects.iter().filter(|object| object.material.opaque.is_none()).count();
        let thin = !sheets.is_empty() && sheets.len() == translucent;
        Ok(Self { text, table, pose, backdrop, thin, wishes, told })
    }

    /// The scene at `frame`, seen from `turn` degrees further round, with `key=value` settings applied in order.
    pub fn scene(&self, turn: f64, sets: &[String], frame: f64, files: &Files) -> Result<Scene> {
        let mut scene = scene_of(&self.text, &self.whole(turn), sets, frame, files)?;
        scene.report.splice(..0, self.text.report.iter().cloned());
        Ok(scene)
    }

    /// Checks the values at `frame` without reading the mesh; returns the picture's size.
    pub fn check(&self, sets: &[String], frame: f64) -> Result<[u32; 2]> {
        Ok(read::read(&self.toml(), &self.text.file, sets, frame)?.framing.size())
    }

    /// Its text, as a scene file that lies in the current folder.
    #[must_use]
    pub fn toml(&self) -> String {
        toml::to_string(&self.whole(0.0)).unwrap_or_default()
    }

    fn whole(&self, turn: f64) -> Table {
        let mut table = self.table.clone();
        let (pose, mut exposure) = (self.pose.turned(turn), 1.0);
        let camera = table.entry("camera").or_insert_with(|| Table::new().into());
        if let Value::Table(camera) = camera {
            pose.place(camera);
            camera.insert("samples".into(), Value::Integer(self.wishes.samples.unwrap_or(8).into()));
            camera.insert("tone".into(), "filmic".into());
            // What the studio adds has the brightness that it is shown with, whatever the file's lights need.
            exposure = camera.get("exposure").and_then(number).unwrap_or(1.0);
            if !self.backdrop.is_own() && !camera.contains_key("exposure") {
                camera.insert("exposure".into(), "auto".into());
            }
            camera.insert("background".into(), self.backdrop.background(exposure));
        }
        if let Some(lights) = self.backdrop.lights(&pose, [self.wishes.ground, self.thin], exposure) {
            table.insert("light".into(), Value::Array(lights));
        }
        if let (true, Some(Value::Array(all))) = (self.wishes.ground, table.get_mut("object")) {
            all.push(lights::ground(&pose));
        }
        table
    }
}

/// The largest extent that is asked for, or else that of skin, mm; none where the mesh's own or a setting's counts.
fn size_mm(wishes: &Wishes, sets: &[String], file: &Path) -> Checked<Option<f64>> {
    let key = |set: &String| set.split('=').next().unwrap_or_default().trim().to_owned();
    let set = sets.iter().find(|set| key(set).starts_with("object.") && key(set).ends_with(".size"));
    match (wishes.size_mm, set) {
        (Some(_), Some(set)) => {
            let fault = Input::new("gives the size a second time").key("--size-mm").found(format!("--set {set}"));
            Err(fault.expected("one of them"))
        }
        (None, None) if !is_gltf(file) => {
            let preset = wishes.preset.as_deref().and_then(Preset::named);
            Ok(preset.filter(|preset| preset.name.starts_with("Skin")).map(|_| SKIN))
        }
        (size, _) => Ok(size),
    }
}

/// The scene of a table; its report is that of its meshes alone.
fn scene_of(text: &Text, table: &Table, sets: &[String], frame: f64, files: &Files) -> Result<Scene> {
    let toml = toml::to_string(table).unwrap_or_default();
    let (name, file, folder) = (text.name.clone(), text.file.clone(), text.folder.clone());
    Scene::of(Text { name, toml, file, folder, alone: true, report: Vec::new() }, sets, frame, files)
}

/// Changes every object of a scene.
fn objects(table: &mut Table, change: impl Fn(&mut Table)) {
    let all = table.get_mut("object").and_then(Value::as_array_mut);
    all.into_iter().flatten().filter_map(Value::as_table_mut).for_each(change);
}

/// Lets light into these of `count` objects from both sides; returns a line that says so.
fn both_sides(table: &mut Table, sheets: &[usize], count: usize, name: &str) -> String {
    let all = table.get_mut("object").and_then(Value::as_array_mut);
    for (_, object) in all.into_iter().flatten().enumerate().filter(|(number, _)| sheets.contains(number)) {
        if let Some(Value::Table(material)) = object.get_mut("material") {
            material.insert("two_sided".into(), Value::Boolean(true));
        }
    }
    let which = match (sheets, count) {
        (_, 1) => "an open sheet without thickness".to_owned(),
        ([_], _) => format!("1 of {count} objects is an open sheet without thickness"),
        _ => format!("{} of {count} objects are open sheets without thickness", sheets.len()),
    };
    format!("{name}: {which}, lit from both sides (--set object.{}.material.two_sided=false: from one)", sheets[0])
}

/// Makes surfaces glossy that have no reflection of their own, lets all light leave that radiosity says, and gives
/// translucent objects the preset, if any.
fn look(table: &mut Table, preset: Option<&str>) {
    objects(table, |object| {
        let Some(Value::Table(material)) = object.get_mut("material") else { return };
        if !material.contains_key("reflection") {
            material.insert("reflection".into(), "ggx".into());
            material.insert("roughness".into(), Value::Float(0.3));
        }
        if material.contains_key("opaque") {
            return;
        }
        material.entry("normalize_exit").or_insert(Value::Boolean(true));
        if let Some(preset) = preset {
            material.retain(|key, _| !["sigma_s_prime", "sigma_a", "eta"].contains(&key));
            material.insert("preset".into(), preset.into());
        }
    });
}

/// Scales an object's size and position.
fn enlarge(object: &mut Table, factor: f64) {
    if let Some(size) = object.get("size").and_then(number) {
        object.insert("size".into(), Value::Float(size * factor));
    }
    if let Some(place) = object.get("position").and_then(vector) {
        object.insert("position".into(), value(place * factor));
    }
}

/// Turns an object whose z axis points upwards about x, so that z becomes y.
fn lay(object: &mut Table) {
    object.insert("rotation".into(), value(DVec3::new(-90.0, 0.0, 0.0)));
    if let Some(place) = object.get("position").and_then(vector) {
        object.insert("position".into(), value(DVec3::new(place.x, place.z, -place.y)));
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

fn vector(value: &Value) -> Option<DVec3> {
    let parts: Vec<f64> = value.as_array()?.iter().filter_map(number).collect();
    Some(DVec3::from_array(parts.try_into().ok()?))
}

fn value(vector: DVec3) -> Value {
    Value::Array(vector.to_array().map(Value::Float).to_vec())
}

/// The mean radiance of an image of the surroundings.
fn mean(image: &str, files: &Files) -> Checked<f64> {
    let mut sky = Sky::of_image(image, [1.0; 3], 0.0);
    // Notes are made when the scene itself is loaded.
    sky.load(files, Path::new(""), "environment", &mut Vec::new())
        .map_err(|fault| Input { key: Some("--environment".into()), ..fault })?;
    Ok(sky.mean().element_sum() / 3.0)
}

#[cfg(test)]
mod tests;
