//! What comes of an action: what has changed, and what is to be written.

use milkglass::error::Error;

/// What an action has changed.
pub(super) enum Changed {
    /// Nothing that is rendered.
    Nothing,
    /// The camera, or what is shown.
    View,
    /// Lights or options.
    Light,
    /// The scene was read again.
    Scene,
}

/// What the user is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) struct Message {
    pub(in super::super) text: String,
    /// Whether something is wrong.
    pub(in super::super) wrong: bool,
}

impl Message {
    /// The message of an error.
    pub(super) fn of(error: &Error) -> Self {
        Self { text: error.to_string(), wrong: true }
    }
}

/// What is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Output {
    /// What is shown, `.png`.
    Png,
    /// The picture in linear radiance, or the layers, `.exr`.
    Exr,
    /// The scene, `.toml`.
    Scene,
    /// The last frames, `.json`.
    Trace,
}

impl Output {
    /// The ending of the file's name.
    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Scene => "toml",
            Self::Trace => "json",
        }
    }

    /// Whether it waits for the whole picture.
    pub(super) fn waits(self) -> bool {
        matches!(self, Self::Png | Self::Exr)
    }
}
