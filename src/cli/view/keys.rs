//! What keys and drags do.

use winit::event::{KeyEvent, Modifiers, MouseButton};
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
    /// Look at all objects.
    Fit,
    /// Move another light.
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
    /// Take another method: steps through the list.
    Method(isize),
    /// Multiply the tolerance.
    Tolerance(f64),
    /// Set the tolerance.
    ToleranceTo(f64),
    Save,
    /// Print the command that renders this picture.
    Tell,
    Undo,
    Redo,
    Reset,
    /// Show the panel, or hide it.
    Panel,
    /// Show the keys, or hide them.
    Keys,
    Quit,
}

impl Action {
    /// Whether an undo takes it back.
    pub(super) fn is_change(&self) -> bool {
        let other = [
            Self::NextLight,
            Self::NextObject,
            Self::Save,
            Self::Tell,
            Self::Undo,
            Self::Redo,
            Self::Panel,
            Self::Keys,
            Self::Quit,
        ];
        !other.contains(self) && !matches!(self, Self::Method(_))
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

/// Degrees of a key.
const TURN: f64 = 5.0;
/// Part of the picture's height of a key.
const SHIFT: f64 = 0.05;
/// Degrees of a pixel of a drag.
const DRAG: f64 = 0.4;
/// Factor of a line of the wheel, and of a key.
const ZOOM: f64 = 0.9;

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
    Row { shown: "f", does: "look at everything", keys: &[("f", Action::Fit)] },
    Row { shown: "l", does: "move the next light", keys: &[("l", Action::NextLight)] },
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
    Row { shown: "s", does: "save the picture", keys: &[("s", Action::Save)] },
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
        _ => return None,
    };
    let state = modifiers.state();
    let prefix = match () {
        () if state.control_key() => "ctrl+",
        () if state.shift_key() => "shift+",
        () => "",
    };
    Some(format!("{prefix}{named}"))
}

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    Orbit,
    Pan,
    Light,
}

impl Drag {
    /// The drag that begins with this button.
    pub(super) fn of(button: MouseButton, modifiers: Modifiers) -> Option<Self> {
        let state = modifiers.state();
        match button {
            MouseButton::Left if state.control_key() => Some(Self::Light),
            MouseButton::Left if state.shift_key() => Some(Self::Pan),
            MouseButton::Left => Some(Self::Orbit),
            MouseButton::Middle => Some(Self::Pan),
            MouseButton::Right => Some(Self::Light),
            _ => None,
        }
    }

    /// What a movement by pixels to the right and downwards does in a picture of this height: things follow the
    /// pointer.
    pub(super) fn moved(self, right: f64, down: f64, height: u32) -> Action {
        let height = f64::from(height.max(1));
        match self {
            Self::Orbit => Action::Orbit(-DRAG * right, DRAG * down),
            Self::Pan => Action::Pan(-right / height, down / height),
            Self::Light => Action::Light(DRAG * right, -DRAG * down),
        }
    }
}

/// What lines of the wheel do, upwards above 0.
pub(super) fn wheel(lines: f64) -> Action {
    Action::Zoom(ZOOM.powf(lines))
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
