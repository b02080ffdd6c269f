//! `--play`: what a user does, from a file, in place of mouse and keyboard.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Deserialize;

use milkglass::error::{Input, Result};

/// Steps of a drag, each followed by a frame.
const STEPS: u32 = 6;
/// How long the window system may take to give the window its size.
const RESIZE: Duration = Duration::from_secs(5);

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Events {
    #[serde(default)]
    event: Vec<Event>,
}

/// `[[event]]`: one thing that is done, after the frame that follows the one before it.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Event {
    /// Press a key, by its name in the table of keys.
    Key(String),
    /// Drag from one pixel of the window to another.
    Drag {
        #[serde(default)]
        button: Button,
        from: [f64; 2],
        to: [f64; 2],
    },
    /// Click at a pixel of the window.
    Click([f64; 2]),
    /// Turn the wheel by so many lines.
    Wheel(f64),
    /// Change a value of the scene: `key=value`.
    Set(String),
    /// Give the window this size in pixels.
    Resize([u32; 2]),
    /// Let so many frames pass.
    Frames(u32),
    /// Wait until the picture is whole.
    Whole(bool),
    /// Wait until nothing is left to do: the picture is whole, and its error estimated.
    Settled(bool),
    /// Wait until a message is shown, or until none is.
    Message(bool),
    /// Write what the window shows as `.png`.
    Screenshot(PathBuf),
    /// Close the window, as its frame's button does.
    Close(bool),
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum Button {
    #[default]
    Left,
    Middle,
    Right,
}

/// What is to be done now.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Deed {
    Key(String),
    /// Move the pointer to a pixel.
    Move([f64; 2]),
    /// Press a button, or release it.
    Press(Button, bool),
    Wheel(f64),
    Set(String),
    Resize([u32; 2]),
    Screenshot(PathBuf),
    Close,
}

/// What events may wait for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// Whether the picture is whole.
    pub(super) whole: bool,
    /// Whether nothing is left to do.
    pub(super) settled: bool,
    /// Whether a message is shown.
    pub(super) message: bool,
    /// The window's width and height in pixels.
    pub(super) size: [u32; 2],
}

/// Events that are played.
pub(super) struct Play {
    events: std::vec::IntoIter<Event>,
    /// The event under way, and its frames so far.
    now: Option<(Event, u32)>,
    since: Instant,
}

impl Play {
    /// Reads the events of a file.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| Input::new(format!("can't be read: {error}")).key("--play").file(path))?;
        let events: Events = toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            Input::new(error.message().lines().next().unwrap_or_default()).key("--play").file(path).line(line)
        })?;
        Ok(Self { events: events.event.into_iter(), now: None, since: Instant::now() })
    }

    /// Whether nothing is left to do.
    pub(super) fn is_over(&self) -> bool {
        self.now.is_none() && self.events.as_slice().is_empty()
    }

    /// What is done after a frame that shows this.
    pub(super) fn next(&mut self, seen: Seen) -> Vec<Deed> {
        if self.now.is_none() {
            self.since = Instant::now();
            self.now = self.events.next().map(|event| (event, 0));
        }
        let Some((event, frame)) = &mut self.now else { return Vec::new() };
        let first = *frame == 0;
        *frame += 1;
        let (deeds, over) = match event {
            Event::Key(name) => (vec![Deed::Key(name.clone())], true),
            Event::Drag { button, from, to } => {
                let part = f64::from(*frame) / f64::from(STEPS);
                let place = [0, 1].map(|k| from[k] + (to[k] - from[k]) * part);
                let start = first.then_some([Deed::Move(*from), Deed::Press(*button, true)]).into_iter().flatten();
                let end = (*frame == STEPS).then_some(Deed::Press(*button, false));
                (start.chain([Deed::Move(place)]).chain(end).collect(), *frame == STEPS)
            }
            // One in each frame, so that the panel sees each.
            Event::Click(at) => match *frame {
                1 => (vec![Deed::Move(*at)], false),
                2 => (vec![Deed::Press(Button::Left, true)], false),
                _ => (vec![Deed::Press(Button::Left, false)], true),
            },
            Event::Wheel(lines) => (vec![Deed::Wheel(*lines)], true),
            Event::Set(set) => (vec![Deed::Set(set.clone())], true),
            Event::Resize(wanted) => {
                let start = first.then_some(Deed::Resize(*wanted));
                (start.into_iter().collect(), seen.size == *wanted || self.since.elapsed() > RESIZE)
            }
            Event::Frames(count) => (Vec::new(), *frame >= *count),
            Event::Message(wanted) => (Vec::new(), seen.message == *wanted),
            Event::Whole(wait) => (Vec::new(), seen.whole || !*wait),
            Event::Settled(wait) => (Vec::new(), seen.settled || !*wait),
            Event::Screenshot(file) => (vec![Deed::Screenshot(file.clone())], true),
            Event::Close(close) => (close.then_some(Deed::Close).into_iter().collect(), true),
        };
        if over {
            self.now = None;
        }
        deeds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn play(text: &str) -> Result<Play> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Play::read(file.path())
    }

    fn seen(whole: bool, side: u32) -> Seen {
        Seen { whole, size: [side; 2], ..Seen::default() }
    }

    #[test]
    fn events_are_done_one_after_another() {
        let text = "event = [{ key = 'f' }, { whole = true }, { drag = { from = [0, 0], to = [6, 12] } }, \
                    { resize = [9, 9] }, { close = true }]";
        let mut play = play(text).unwrap();
        assert_eq!(play.next(seen(false, 8)), [Deed::Key("f".into())]);
        assert_eq!(play.next(seen(false, 8)), []);
        assert_eq!(play.next(seen(true, 8)), []);
        let begin = [Deed::Move([0.0; 2]), Deed::Press(Button::Left, true), Deed::Move([1.0, 2.0])];
        assert_eq!(play.next(seen(true, 8)), begin);
        for step in 2..6 {
            assert_eq!(play.next(seen(true, 8)), [Deed::Move([f64::from(step), 2.0 * f64::from(step)])]);
        }
        assert_eq!(play.next(seen(true, 8)), [Deed::Move([6.0, 12.0]), Deed::Press(Button::Left, false)]);
        assert_eq!(play.next(seen(true, 8)), [Deed::Resize([9, 9])]);
        assert_eq!(play.next(seen(true, 8)), []);
        assert_eq!(play.next(seen(true, 9)), []);
        assert!(!play.is_over());
        assert_eq!(play.next(seen(true, 9)), [Deed::Close]);
        assert!(play.is_over() && play.next(seen(true, 9)).is_empty());
    }

    #[test]
    fn a_fault_has_file_and_line() {
        let error = play("[[event]]\nkey = 'f'\n\n[[event]]\nkick = 3\n").err().unwrap();
        assert!(error.to_string().contains(": --play: unknown variant `kick`") && error.exit_code() == 2, "{error}");
        let error = play("[[event]]\nwheel = 'x'\n").err().unwrap();
        assert!(error.to_string().contains(":2: --play: invalid type"), "{error}");
        assert!(Play::read(Path::new("/nowhere.toml")).err().unwrap().to_string().contains("can't be read"));
    }
}
