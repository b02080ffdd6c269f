//! What keys and drags do.

use winit::event::{KeyEvent, Modifiers};
use winit::keyboard::{Key, NamedKey};

/// What the user asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Action {
    /// Move the camera around, by degrees to the right and upwards.
    Orbit(f64, f64),
    /// Shift the camera, by parts of the picture's height.
    Pan(f64, f64),
    /// Multiply the camera's distance.
    Zoom(f64),
    /// Turn the light, by degrees to the right and upwards.
    Light(f64, f64),
    /// Shift the light, by parts of the picture's height to the right and upwards.
    Shift(f64, f64),
    /// Multiply what the light emits.
    Brighten(f64),
    /// Look at all objects.
    Fit,
    /// Change another light.
    NextLight,
    /// Change another object.
    NextObject,
    /// Give the object another preset: steps through the list.
    Material(isize),
    /// Give the object the preset of this name.
    Preset(String),
    /// Multiply the object's size.
    Size(f64),
    /// Set the factor on the object's coefficients.
    Scale(f64),
    /// Change another deformation.
    NextDeform,
    /// Add a twist to the object.
    Twist,
    /// Deform the object further: by parts of what its slider offers.
    Deform(f64),
    /// Set the amount of the deformation of this number.
    DeformTo(usize, f64),
    /// Go on by so many frames.
    Frame(f64),
    /// Go to a frame.
    FrameTo(f64),
    /// Play the animation, or stop it.
    Play,
    /// Begin again after the last frame, or stop there.
    Loop,
    /// Take another method: steps through the list.
    Method(isize),
    /// Take the other scheme.
    Scheme,
    /// Keep other things between frames: the next mode.
    Mode,
    /// Show another layer: steps through the list.
    Layer(isize),
    /// Show the clusters that light the point under the pointer.
    Pick,
    /// Multiply the tolerance.
    Tolerance(f64),
    /// Sharpen the error's estimate.
    Sharpen,
    /// Set the tolerance.
    ToleranceTo(f64),
    Save,
    /// Save the picture, or the layers, as OpenEXR.
    SaveExr,
    /// Save the scene.
    SaveScene,
    /// Save the times of the last frames.
    Trace,
    /// Print the command that renders this picture.
    Tell,
    Undo,
    Redo,
    Reset,
    /// Show the lights' handles, or hide them.
    Handles,
    /// Show the panel, or hide it.
    Panel,
    /// Show the keys, or hide them.
    Keys,
    Quit,
}

impl Action {
    /// Whether an undo takes it back.
    pub(super) fn is_change(&self) -> bool {
        matches!(
            self,
            Self::Orbit(..)
                | Self::Pan(..)
                | Self::Zoom(_)
                | Self::Light(..)
                | Self::Shift(..)
                | Self::Brighten(_)
                | Self::Fit
                | Self::Material(_)
                | Self::Preset(_)
                | Self::Size(_)
                | Self::Scale(_)
                | Self::Twist
                | Self::Deform(_)
                | Self::DeformTo(..)
                | Self::Scheme
                | Self::Tolerance(_)
                | Self::ToleranceTo(_)
                | Self::Reset
        )
    }
}

/// A line of the table of keys.
pub(super) struct Row {
    /// Keys and drags as they are shown.
    pub(super) shown: &'static str,
    /// What they do.
    pub(super) does: &'static str,
    keys: &'static [(&'static str, Action)],
}

/// Degrees per key press.
const TURN: f64 = 5.0;
/// Part of the picture's height per key press.
const SHIFT: f64 = 0.05;
/// Factor on the camera's distance per line of the wheel, and per key press.
pub(super) const ZOOM: f64 = 0.9;

/// Every key and drag.
pub(super) const ROWS: &[Row] = &[
    Row {
        shown: "left drag, arrows",
        does: "turn the view",
        keys: &[
            ("left", Action::Orbit(-TURN, 0.0)),
            ("right", Action::Orbit(TURN, 0.0)),
            ("up", Action::Orbit(0.0, TURN)),
            ("down", Action::Orbit(0.0, -TURN)),
        ],
    },
    Row {
        shown: "middle or shift drag, shift arrows",
        does: "shift the view",
        keys: &[
            ("shift+left", Action::Pan(-SHIFT, 0.0)),
            ("shift+right", Action::Pan(SHIFT, 0.0)),
            ("shift+up", Action::Pan(0.0, SHIFT)),
            ("shift+down", Action::Pan(0.0, -SHIFT)),
        ],
    },
    Row {
        shown: "wheel, + and -",
        does: "zoom",
        keys: &[("+", Action::Zoom(ZOOM)), ("=", Action::Zoom(ZOOM)), ("-", Action::Zoom(1.0 / ZOOM))],
    },
    Row {
        shown: "right or ctrl drag, ctrl arrows",
        does: "turn the light",
        keys: &[
            ("ctrl+left", Action::Light(-TURN, 0.0)),
            ("ctrl+right", Action::Light(TURN, 0.0)),
            ("ctrl+up", Action::Light(0.0, TURN)),
            ("ctrl+down", Action::Light(0.0, -TURN)),
        ],
    },
    Row {
        shown: "drag of a handle, alt arrows",
        does: "shift the light",
        keys: &[
            ("alt+left", Action::Shift(-SHIFT, 0.0)),
            ("alt+right", Action::Shift(SHIFT, 0.0)),
            ("alt+up", Action::Shift(0.0, SHIFT)),
            ("alt+down", Action::Shift(0.0, -SHIFT)),
        ],
    },
    Row { shown: "h", does: "hide or show the lights' handles", keys: &[("h", Action::Handles)] },
    Row { shown: "f", does: "look at everything", keys: &[("f", Action::Fit)] },
    Row { shown: "l", does: "change the next light", keys: &[("l", Action::NextLight)] },
    Row {
        shown: "{ and }",
        does: "light a tenth dimmer and brighter",
        keys: &[("{", Action::Brighten(1.0 / 1.1)), ("}", Action::Brighten(1.1))],
    },
    Row { shown: "o", does: "change the next object", keys: &[("o", Action::NextObject)] },
    Row {
        shown: "m and M",
        does: "next and previous material",
        keys: &[("m", Action::Material(1)), ("M", Action::Material(-1))],
    },
    Row {
        shown: "[ and ]",
        does: "a tenth smaller and larger",
        keys: &[("[", Action::Size(1.0 / 1.1)), ("]", Action::Size(1.1))],
    },
    Row { shown: "d", does: "change the next deformation", keys: &[("d", Action::NextDeform)] },
    Row { shown: "w", does: "add a twist", keys: &[("w", Action::Twist)] },
    Row {
        shown: "< and >",
        does: "deform less and more",
        keys: &[("<", Action::Deform(-0.05)), (">", Action::Deform(0.05))],
    },
    Row { shown: "space", does: "play or stop", keys: &[("space", Action::Play)] },
    Row {
        shown: "n and N",
        does: "next and previous frame",
        keys: &[("n", Action::Frame(1.0)), ("N", Action::Frame(-1.0))],
    },
    Row { shown: "b", does: "begin again at the end, or not", keys: &[("b", Action::Loop)] },
    Row {
        shown: "t and T",
        does: "next and previous method",
        keys: &[("t", Action::Method(1)), ("T", Action::Method(-1))],
    },
    Row {
        shown: ", and .",
        does: "half and twice the tolerance",
        keys: &[(",", Action::Tolerance(0.5)), (".", Action::Tolerance(2.0))],
    },
    Row { shown: "a", does: "sharpen the estimated error", keys: &[("a", Action::Sharpen)] },
    Row { shown: "y", does: "the other scheme", keys: &[("y", Action::Scheme)] },
    Row { shown: "k", does: "the next mode", keys: &[("k", Action::Mode)] },
    Row {
        shown: "v and V",
        does: "next and previous layer",
        keys: &[("v", Action::Layer(1)), ("V", Action::Layer(-1))],
    },
    Row { shown: "x", does: "clusters that light the point at the pointer", keys: &[("x", Action::Pick)] },
    Row { shown: "s", does: "save the picture", keys: &[("s", Action::Save)] },
    Row { shown: "e", does: "save it as OpenEXR", keys: &[("e", Action::SaveExr)] },
    Row { shown: "S", does: "save the scene", keys: &[("S", Action::SaveScene)] },
    Row { shown: "g", does: "save a trace of the last frames", keys: &[("g", Action::Trace)] },
    Row { shown: "c", does: "print the command that renders it", keys: &[("c", Action::Tell)] },
    Row { shown: "u and U", does: "undo and redo", keys: &[("u", Action::Undo), ("U", Action::Redo)] },
    Row { shown: "r", does: "back to the file", keys: &[("r", Action::Reset)] },
    Row { shown: "p", does: "hide or show the panel", keys: &[("p", Action::Panel)] },
    Row { shown: "?", does: "hide or show the keys", keys: &[("?", Action::Keys)] },
    Row { shown: "q, escape", does: "quit", keys: &[("q", Action::Quit), ("escape", Action::Quit)] },
];

/// What the key of this name does.
pub(super) fn action(name: &str) -> Option<Action> {
    let all = ROWS.iter().flat_map(|row| row.keys);
    all.clone().find(|(key, _)| *key == name).map(|(_, action)| action.clone())
}

/// The name of a key that was pressed: a character, or `shift+left` and the like.
pub(super) fn name(event: &KeyEvent, modifiers: Modifiers) -> Option<String> {
    let named = match &event.logical_key {
        Key::Character(text) => return Some(text.to_string()),
        Key::Named(NamedKey::ArrowLeft) => "left",
        Key::Named(NamedKey::ArrowRight) => "right",
        Key::Named(NamedKey::ArrowUp) => "up",
        Key::Named(NamedKey::ArrowDown) => "down",
        Key::Named(NamedKey::Escape) => "escape",
        Key::Named(NamedKey::Space) => return Some("space".into()),
        _ => return None,
    };
    let state = modifiers.state();
    let prefix = match () {
        () if state.control_key() => "ctrl+",
        () if state.alt_key() => "alt+",
        () if state.shift_key() => "shift+",
        () => "",
    };
    Some(format!("{prefix}{named}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_named_once_and_shown() {
        let mut seen = std::collections::BTreeSet::new();
        for row in ROWS {
            for (key, wanted) in row.keys {
                assert!(seen.insert(key), "{key} twice");
                assert_eq!(action(key).as_ref(), Some(wanted));
                let arrow = ["left", "right", "up", "down"].iter().any(|name| key.ends_with(name));
                let words: Vec<&str> = row.shown.split([' ', ',']).chain([","]).collect();
                assert!(arrow || *key == "=" || words.contains(key), "{key} is not shown in {:?}", row.shown);
            }
        }
        let guide = include_str!("../../guide/window.md");
        for row in ROWS {
            assert!(guide.contains(&format!("| `{}` | {} |", row.shown, row.does)), "the guide lacks {:?}", row.shown);
        }
    }
}
