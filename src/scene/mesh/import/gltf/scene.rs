//! The scene of a glTF file alone: an object per part, the file's camera and lights.

use super::document::{Document, extension, gone, number, numbers};
use super::material::{Medium, of_part};
use super::{Assembly, Checked, Files, Input, Local, Parts, Tree};
use glam::{DMat4, DVec3};
use gltf::json::Value as Json;
use gltf::json::validation::Checked::Valid;
use toml::{Table, Value};

/// Lumens per watt, at 555 nm: what `KHR_lights_punctual` gives in candela and lux becomes W/sr and W/m^2.
const LUMENS: f64 = 683.0;
/// Maximum number of parts: as many as a scene may have objects.
const MOST: usize = 256;
/// Largest extent of a mesh to which the scene around it gives no size, millimetres.
const USUAL: f64 = 20.0;

/// Maps the file's metres to scene units.
struct Frame {
    middle: DVec3,
    scale: f64,
}

impl Frame {
    fn place(&self, point: DVec3) -> Value {
        list((point - self.middle) * self.scale)
    }
}

fn list(v: DVec3) -> Value {
    // Adding 0 turns -0 into 0.
    Value::Array((v + DVec3::ZERO).to_array().map(Value::Float).to_vec())
}

/// Changes the scene `around` a mesh into that of the file; returns it with notes.
pub(super) fn scene(document: &Document, files: &Files, mut around: Table) -> Checked<(Table, Vec<String>)> {
    let tree = Tree::of(document)?;
    let parts = Parts::of(document, &tree, None)?;
    let locals = Local::rest(document);
    let world = tree.world(&locals);
    let mut notes = Vec::new();

    // Objects: the first of the scene around the mesh is the model of all.
    let Some(Value::Array(objects)) = around.get_mut("object") else { return Ok((around, notes)) };
    let Some(Value::Table(model)) = objects.first().cloned() else { return Ok((around, notes)) };
    let (low, high) = Assembly::of(document, files, &tree, &locals, &parts.all)?.bounds();
    let extent = (high - low).max_element();
    // The mesh's own reader says what is wrong.
    if !(extent > 0.0 && extent.is_finite()) {
        return Ok((around, notes));
    }
    if parts.all.len() > MOST {
        let fault = Input::new("the meshes of the file have too many materials").found(parts.all.len());
        return Err(fault.expected(format!("at most {MOST}, as many as a scene has objects")));
    }
    let media = document.root.materials.iter().enumerate();
    let physical = media.filter(|(index, _)| parts.all.contains(&Some(*index))).any(|(_, m)| Medium::of(m).is_some());
    let size = model.get("size").and_then(|size| size.as_float().or(size.as_integer().map(|size| size as f64)));
    let scale = if physical { 1000.0 } else { size.unwrap_or(USUAL) / extent };
    let frame = Frame { middle: (low + high) / 2.0, scale };
    let mut made = Vec::new();
    for (number, material) in parts.all.iter().enumerate() {
        let part = Parts { all: parts.all.clone(), chosen: vec![*material] };
        let mut object = model.clone();
        let around = model.get("material").and_then(Value::as_table).cloned().unwrap_or_default();
        object.insert("material".into(), of_part(document, &tree, &part, &around, &mut notes)?.into());
        if parts.all.len() > 1 {
            let (low, high) = Assembly::of(document, files, &tree, &locals, &part.chosen)?.bounds();
            object.insert("part".into(), Value::Integer(number as i64));
            object.insert("size".into(), ((high - low).max_element() * scale).into());
            object.insert("position".into(), frame.place((low + high) / 2.0));
        } else {
            object.insert("size".into(), (extent * scale).into());
        }
        made.push(Value::Table(object));
    }
    objects.splice(..1, made);
    if physical {
        notes.push(format!(
            "materials: scattering per metre, as in the file; the mesh is {:.1} mm across",
            extent * scale
        ));
    }

    // Camera and lights.
    let exposed = lights(document, &tree, &world, &frame, &mut around, &mut notes)?;
    if let Some(mut camera) = camera(document, &tree, &world, &frame, &mut notes)? {
        if let Some(Value::Table(given)) = around.remove("camera") {
            camera.extend(
                given.into_iter().filter(|(name, _)| !["position", "target", "up", "fov"].contains(&name.as_str())),
            );
        }
        around.insert("camera".into(), camera.into());
    }
    if exposed {
        let camera = around.entry("camera").or_insert_with(|| Table::new().into());
        if let Value::Table(camera) = camera {
            camera.insert("exposure".into(), LUMENS.into());
        }
    }
    Ok((around, notes))
}

/// Replaces the lights by the file's; returns whether it has any.
fn lights(
    document: &Document,
    tree: &Tree,
    world: &[DMat4],
    frame: &Frame,
    around: &mut Table,
    notes: &mut Vec<String>,
) -> Checked<bool> {
    let all =
        extension!(document.root, "KHR_lights_punctual").and_then(|all| all.get("lights")).and_then(Json::as_array);
    let mut made = Vec::new();
    for node in tree.shown() {
        let Some(value) = extension!(document.root.nodes[node], "KHR_lights_punctual") else { continue };
        let index = number(Some(value), "light", -1.0);
        let light = all.and_then(|all| all.get(index as usize)).filter(|_| index >= 0.0);
        let light = light.ok_or_else(|| Input::new("there is no light of this number").found(index))?;
        made.push(Value::Table(self::light(light, world[node], frame)?));
    }
    if made.is_empty() {
        return Ok(false);
    }
    notes.push(format!(
        "lights: {} of the file, in candela and lux: divided by {LUMENS} lm/W, with exposure {LUMENS}",
        made.len()
    ));
    around.insert("light".into(), Value::Array(made));
    Ok(true)
}

/// A light of the file; it shines along -z of its node.
fn light(light: &Json, world: DMat4, frame: &Frame) -> Checked<Table> {
    let color = numbers(Some(light), "color", [1.0; 3]);
    let amount = number(Some(light), "intensity", 1.0) / LUMENS;
    let back = world.transform_vector3(DVec3::Z).normalize_or(DVec3::Z);
    let times = |factor: f64| Value::Array(color.map(|c| Value::Float(c * amount * factor)).to_vec());
    let mut made = Table::new();
    let kind = light.get("type").and_then(Json::as_str).unwrap_or_default();
    made.insert("type".into(), kind.into());
    if kind == "directional" {
        made.insert("direction".into(), list(back));
        made.insert("irradiance".into(), times(1.0));
        return Ok(made);
    }
    made.insert("position".into(), frame.place(world.w_axis.truncate()));
    // The irradiance at a distance stays the same.
    made.insert("intensity".into(), times(frame.scale * frame.scale));
    match kind {
        "point" => {}
        "spot" => {
            let spot = light.get("spot");
            let outer = number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4).to_degrees().clamp(1.0, 90.0);
            let inner = number(spot, "innerConeAngle", 0.0).to_degrees().clamp(0.0, 0.95 * outer);
            made.insert("direction".into(), list(-back));
            made.insert("outer".into(), outer.into());
            made.insert("inner".into(), inner.into());
        }
        other => {
            let fault = Input::new("the type of a light is not one of KHR_lights_punctual").found(other);
            return Err(fault.expected("directional, point or spot"));
        }
    }
    Ok(made)
}

/// The first camera of the file; it looks along -z of its node.
fn camera(
    document: &Document,
    tree: &Tree,
    world: &[DMat4],
    frame: &Frame,
    notes: &mut Vec<String>,
) -> Checked<Option<Table>> {
    let camera_of = |node: usize| document.root.nodes[node].camera.map(|camera| (node, camera.value()));
    let all: Vec<(usize, usize)> = tree.shown().filter_map(camera_of).collect();
    let Some(&(node, index)) = all.first() else { return Ok(None) };
    let camera = document.root.cameras.get(index).ok_or_else(|| gone("camera", index))?;
    let Some(perspective) = camera.perspective.as_ref().filter(|_| matches!(camera.type_, Valid(_))) else {
        notes.push("ignored: the file's camera, which is orthographic".to_owned());
        return Ok(None);
    };
    if all.len() > 1 {
        notes.push(format!("camera: the first of {} in the file", all.len()));
    }
    let matrix = world[node];
    let position = matrix.w_axis.truncate();
    let forward = matrix.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
    let ahead = (frame.middle - position).dot(forward);
    let ahead = if ahead > 0.0 { ahead } else { 1.0 };
    let mut made = Table::new();
    made.insert("position".into(), frame.place(position));
    made.insert("target".into(), frame.place(position + forward * ahead));
    made.insert("up".into(), list(matrix.transform_vector3(DVec3::Y).normalize_or(DVec3::Y)));
    made.insert("fov".into(), f64::from(perspective.yfov).to_degrees().into());
    Ok(Some(made))
}
