//! Reads a scene's text and applies its `--set` changes: returns a checked draft, or an error with its location.

use super::file::{Draft, SceneFile};
use super::range::Checked;
use super::{animate, locate, overrides};
use crate::error::Input;
use serde::Deserialize;
use std::path::Path;
use toml::{Table, Value};

/// Reads `text` of `file`, applies `sets` in order, evaluates keyframes at `frame`, and checks the result. An error in
/// the file itself carries file and line; an error caused by a setting names that setting.
pub(super) fn read(text: &str, file: &Path, sets: &[String], frame: f64) -> Checked<Draft> {
    let original: Table = toml::from_str(text).map_err(|error| locate::from_toml(&error, text, file))?;
    changed(&original, sets, frame).or_else(|fault| {
        check_text(&original, text, file, frame)?;
        Err(blame(&original, sets, frame, fault))
    })
}

/// Locates an error that is found once the mesh is loaded: at the setting of its key, or else in the text.
pub(super) fn place(fault: Input, text: &str, file: &Path, sets: &[String]) -> Input {
    let key_of = |set: &&String| set.split('=').next().map(str::trim).map(str::to_owned);
    let culprit = sets.iter().rev().find(|set| fault.key.is_some() && key_of(set) == fault.key);
    match (culprit, &fault.key) {
        (Some(set), Some(key)) => {
            let key = format!("--set {set}: {key}");
            Input { key: Some(key), ..fault }
        }
        _ => locate::from_check(fault, text, file),
    }
}

/// The draft after these settings have been applied.
fn changed(original: &Table, sets: &[String], frame: f64) -> Checked<Draft> {
    let mut table = original.clone();
    for setting in sets {
        overrides::apply(&mut table, setting)?;
    }
    let (still, _) = animate::at(&table, frame)?;
    let scene = SceneFile::deserialize(still.clone()).map_err(|error| locate::in_words(error.message()))?;
    Ok(Draft { frames: animate::frames(&Value::Table(table)), ..scene.check(&still)? })
}

/// The draft of the text alone; errors carry file and line.
fn check_text(original: &Table, text: &str, file: &Path, frame: f64) -> Checked<Draft> {
    // A text with keyframes does not deserialize as it is: find lines by key alone.
    match animate::at(original, frame) {
        Ok((_, false)) => {}
        _ => return changed(original, &[], frame).map_err(|fault| locate::from_check(fault, text, file)),
    }
    let scene: SceneFile = toml::from_str(text).map_err(|error| locate::from_toml(&error, text, file))?;
    scene.check(original).map_err(|fault| locate::from_check(fault, text, file))
}

/// Names the setting that caused the error: the one after the longest run of settings that gives a valid scene.
fn blame(original: &Table, sets: &[String], frame: f64, mut fault: Input) -> Input {
    let good = |count: &usize| changed(original, &sets[..*count], frame).is_ok();
    let Some(culprit) = (0..sets.len()).rev().find(good).and_then(|count| sets.get(count)) else {
        return fault;
    };
    fault.key = Some(match fault.key {
        Some(key) if key.starts_with("--set ") => key,
        Some(key) => format!("--set {culprit}: {key}"),
        None => format!("--set {culprit}"),
    });
    fault
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "[[light]]\ntype = 'point'\nposition = [0, 0, 9]\nintensity = 1\n\n\
                        [[object]]\nshape = 'slab'\nsize = 20\nmaterial = { preset = 'apple' }\n";

    fn message(text: &str, sets: &[&str]) -> String {
        let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
        let result = read(text, Path::new("a.toml"), &sets, 0.0);
        result.err().map(|fault| fault.to_string()).unwrap_or_default()
    }

    #[test]
    fn faults_of_the_file_carry_file_line_and_key() {
        let cases = [
            (
                GOOD.replace("[[light]]", "[camera]\nfow = 3\n[[light]]"),
                "a.toml:2: camera.fow: unknown key, did you mean `fov`?; found fow; expected position,",
            ),
            (
                GOOD.replace("size", "sice"),
                "a.toml:8: object.0.sice: unknown key, did you mean `size`?; found sice; expected mesh",
            ),
            (GOOD.replace("20", "-20"), "a.toml:8: object.0.size: out of range; found -20"),
            (GOOD.replace("preset", "prest"), "a.toml:9: object.0.material.prest: unknown key, did"),
            (GOOD.replace("apple", "appel"), "a.toml:9: object.0.material.preset: unknown preset, did"),
            (GOOD.replace("'slab'", "'slap'"), "a.toml:7: object.0.shape: unknown value, did you mean `slab`?"),
            (GOOD.replace("'slab'", "'slab'\nmesh = 'a'"), "a.toml:7: object.0.shape: both a mesh"),
            (GOOD.replace("shape = 'slab'\n", ""), "a.toml:6: object.0: neither a mesh nor a shape"),
            (GOOD.replace("size", "detail = 0\nsize"), "a.toml:8: object.0.detail: out of range; found 0"),
            (GOOD.replace("[0, 0, 9]", "[0, 9]"), "a.toml:3: light.0.position: invalid length 2"),
            (GOOD.replace("intensity = 1\n", ""), "a.toml:1: light.0.intensity: missing"),
            (GOOD.replace("= 1\n", "= 1 1\n"), "a.toml:4: "),
            (format!("{GOOD}[[object]]\nshape = 'slab'"), "a.toml:10: object.1.material.sigma_s_prime: missing"),
            ("unit = 'inch'".into(), "a.toml:1: unit: unknown value; found inch; expected um, mm, cm, m"),
            (String::new(), "a.toml: object: there is nothing to show; found 0 times [[object]]; expected 1 to 256"),
        ];
        for (text, expected) in cases {
            let found = message(&text, &[]);
            assert!(found.starts_with(expected), "{found}");
        }
    }

    #[test]
    fn faults_of_a_setting_name_it() {
        let cases: [(&[&str], &str); 6] = [
            (&["camera.fov=30", "object.0.size=-3"], "--set object.0.size=-3: object.0.size: out of range"),
            (&["camera.fow=30", "unit=cm"], "--set camera.fow=30: unknown key, did you mean `fov`?"),
            (&["object.1.shape=slab"], "--set object.1.shape=slab: object.1.material.sigma_s_prime: missing"),
            (&["object.0.material.preset=mable"], "--set object.0.material.preset=mable: object.0.mat"),
            (&["light.5.x=1"], "--set light.5.x=1: `light` is a list of 1; it has no `5`"),
            (&["light"], "--set light: not a setting"),
        ];
        for (sets, expected) in cases {
            let found = message(GOOD, sets);
            assert!(found.starts_with(expected), "{found}");
        }
    }

    #[test]
    fn settings_may_complete_a_file() {
        let text = "[[object]]\nsize = 3\n";
        let sets = ["object.0.shape=slab", "object.0.material.preset=whole milk"];
        assert_eq!(message(text, &sets), "");
        assert!(message(text, &sets[..1]).starts_with("a.toml:1: object.0: neither a mesh"));
        let light = ["light.1.type=point", "light.1.position=[1,2,3]", "light.1.intensity=1"];
        assert_eq!(message(GOOD, &light), "");
    }
}
