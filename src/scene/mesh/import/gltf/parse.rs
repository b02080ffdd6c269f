//! Parses the JSON of glTF. What the format allows and the crate refuses is mended before: `extras` of any type and
//! channels of animations that move no node are taken out, scenes without nodes get an empty list of them.

use crate::error::Input;
use crate::scene::range::Checked;
use gltf::json::{Root, Value};
use serde::Deserialize;
use serde_json::{Map, from_slice};

/// Parses the JSON of a file of glTF 2.0; an error has its line if the text is the file.
pub(super) fn parse(text: &[u8], is_file: bool) -> Checked<Root> {
    let (error, version) = match from_slice::<Root>(text) {
        Ok(root) if root.asset.version.starts_with("2.") => return Ok(root),
        Ok(root) => return Err(another(&root.asset.version)),
        Err(error) => match from_slice::<Value>(text) {
            Err(error) => (error, None),
            Ok(mut value) => {
                let version = value.pointer("/asset/version").and_then(Value::as_str).map(str::to_owned);
                // Before 2.0, lists were objects, and the version did not have to be there.
                let version = version.or_else(|| value.get("meshes")?.is_object().then(|| "1.0".to_owned()));
                match mend(&mut value).then(|| Root::deserialize(value)) {
                    Some(Ok(root)) if root.asset.version.starts_with("2.") => return Ok(root),
                    Some(Err(error)) => (error, version),
                    _ => (error, version),
                }
            }
        },
    };
    if let Some(version) = version.filter(|version| !version.starts_with("2.")) {
        return Err(another(&version));
    }
    let words = error.to_string();
    let fault = not_gltf(words.split(" at line ").next().unwrap_or_default());
    Err(if is_file && error.line() > 0 { fault.line(error.line()) } else { fault })
}

/// The error for a file that is not glTF 2.0.
pub(super) fn not_gltf(found: &str) -> Input {
    Input::new("the mesh file is not glTF 2.0 as it should be").found(found)
}

/// The error for another version of glTF.
pub(super) fn another(version: &str) -> Input {
    Input::new("another version of glTF").found(version).expected("asset.version 2.0")
}

/// Mends what the crate refuses; returns whether there was any.
fn mend(root: &mut Value) -> bool {
    let mut mended = without_extras(root);
    for scene in objects(root, "scenes").filter(|scene| !scene.contains_key("nodes")) {
        scene.insert("nodes".into(), Value::Array(Vec::new()));
        mended = true;
    }
    for animation in objects(root, "animations") {
        if let Some(Value::Array(channels)) = animation.get_mut("channels") {
            let before = channels.len();
            channels.retain(|channel| channel.pointer("/target/node").is_some());
            mended |= channels.len() < before;
        }
    }
    mended
}

/// Removes `extras` everywhere; returns whether there were any.
fn without_extras(value: &mut Value) -> bool {
    match value {
        Value::Array(all) => all.iter_mut().fold(false, |mended, value| without_extras(value) | mended),
        Value::Object(all) => {
            let mended = all.remove("extras").is_some();
            all.values_mut().fold(mended, |mended, value| without_extras(value) | mended)
        }
        _ => false,
    }
}

/// The objects in a list of the root.
fn objects<'a>(root: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Map<String, Value>> {
    root.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_object_mut)
}
