//! `milkglass render --frames`: one picture per frame, the same as if each were rendered alone, but for a metered
//! exposure, which is that of frame 0.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use super::bare::Subject;
use super::long_work::tell_long_work;
use super::samples::Samples;
use super::{check_messages, open_session, run_frame};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, Timing};
use milkglass::internals::phases::phase;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::prepare::shape::turned;
use milkglass::internals::session::aov::layers;
use milkglass::internals::session::run::Session;
use milkglass::internals::view::aov::save;
use milkglass::scene::{numbered as numbered_text, path_of_text, text_of_path};

/// Most frames in one call.
const MOST: i64 = 1_000_000;

/// The frames of one call.
pub struct Job<'a> {
    /// The scene, by frame.
    pub scenes: &'a Subject,
    /// The frames' numbers.
    pub frames: RangeInclusive<i32>,
    /// Width and height of the pictures, if other than the scene's.
    pub size: Option<[u32; 2]>,
    /// Transport, mode and goal.
    pub options: Options,
    /// The output path, with a placeholder for the number.
    pub output: &'a Path,
    /// Whether pictures have layers.
    pub aov: bool,
    /// Whether frames whose file exists are skipped.
    pub skip: bool,
}

impl Job<'_> {
    /// Renders the frames, with a progress bar and a summary.
    pub fn run(self, device: Option<&Device>) -> Result<()> {
        let scene = &self.scenes.scenes.scene;
        if Path::new(scene).metadata().is_ok_and(|known| !known.is_file() && !known.is_dir()) {
            let fault = Input::new("the scene is read again for every frame").key("--frames").found(scene);
            return Err(fault.expected("a plain file").into());
        }
        let start = Instant::now();
        let output = |frame: i32| numbered(self.output, frame).unwrap_or_default();
        // Only a non-empty file counts as a picture.
        let whole = |path: &Path| path.metadata().is_ok_and(|known| known.is_file() && known.len() > 0);
        let skips = |frame: &i32| self.skip && whole(&output(*frame));
        let (left_out, wanted): (Vec<i32>, Vec<i32>) = self.frames.clone().partition(skips);
        wanted.iter().try_for_each(|&frame| {
            let told = |_: &Error| tell!("the scene is not valid at frame {frame}; nothing was rendered");
            self.scenes.check(f64::from(frame)).inspect_err(told)
        })?;
        let bar = ProgressBar::new(wanted.len() as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} frames, {eta} left") {
            bar.set_style(style);
        }
        let mut session = self.metered(device)?;
        let mut render = |frame: i32| -> Result<()> {
            let mut scene = self.scenes.at(f64::from(frame))?;
            scene.camera = scene.camera.clone().sized(self.size.unwrap_or(scene.camera.size))?;
            let session = match &mut session {
                None => {
                    scene.report.iter().for_each(|line| tell!("{line}"));
                    let opened = open_session(&scene, device, self.options)?;
                    tell_long_work(&opened);
                    session.insert(opened)
                }
                Some(session) => {
                    session.show(&scene).map_err(|error| scene.placed(error))?;
                    bar.suspend(|| warn_of_shape(session, &format!("frame {frame}: ")));
                    session
                }
            };
            run_frame(session, Change::default())?;
            check_messages(device)?;
            shoot(session, self.aov, &output(frame), Samples::hidden())?;
            check_messages(device)?;
            bar.inc(1);
            Ok(())
        };
        for (done, &frame) in wanted.iter().enumerate() {
            render(frame).inspect_err(|_| {
                bar.finish_and_clear();
                tell!("frame {frame} failed; the {done} before it are whole, and --skip-existing goes on from here");
            })?;
        }
        bar.finish_and_clear();
        let place = device.map_or("the CPU", |device| device.name());
        let (count, there) = (wanted.len(), left_out.len());
        let there = if there > 0 { format!(", {there} were there") } else { String::new() };
        let seconds = start.elapsed().as_secs_f64();
        tell!("{count} frames{there}, on {place}, {seconds:.1} s");
        Ok(())
    }
}

impl Job<'_> {
    /// For a film whose camera is metered, a session that has found the exposure from frame 0, or else from the first
    /// frame of the range, so that films rendered in parts have one exposure; none for any other film.
    fn metered(&self, device: Option<&Device>) -> Result<Option<Session>> {
        let at = |frame: f64| self.scenes.check(frame).and_then(|()| self.scenes.at(frame));
        let first = f64::from(*self.frames.start());
        let Some(mut scene) = at(0.0).or_else(|_| at(first)).ok().filter(|scene| scene.camera.metered) else {
            return Ok(None);
        };
        scene.camera = scene.camera.clone().sized(self.size.unwrap_or(scene.camera.size))?;
        scene.report.iter().for_each(|line| tell!("{line}"));
        let mut session = open_session(&scene, device, self.options)?;
        tell_long_work(&session);
        run_frame(&mut session, Change::default())?;
        session.sample()?;
        let exposure = session.picture()?.exposure;
        session.hold_exposure(Some(exposure));
        tell!("exposure {exposure:.3} in all frames");
        Ok(Some(session))
    }
}

/// Deforms the session's objects, and reports trees that had to be rebuilt and triangles that are turned inside out,
/// where the picture is wrong.
pub fn warn_of_shape(session: &mut Session, frame: &str) {
    session.deform();
    session.rebuilt().iter().for_each(|line| tell!("{frame}{line}"));
    for (object, count) in turned(session.state()).into_iter().enumerate().filter(|(_, count)| *count > 0) {
        let all = session.state().objects[object].count.faces;
        tell!(
            "{frame}object {object}: its deformations turn {count} of {all} triangles inside out or leave them without an area"
        );
    }
}

/// Writes the picture of the last frame, with layers if `aov`; `samples` shows how many are done. Returns the times of
/// the samples' steps.
pub fn shoot(session: &mut Session, aov: bool, output: &Path, mut samples: Samples) -> Result<Vec<Timing>> {
    // Layers first: they belong to rays through the pixels' centres.
    let layers = if aov { Some(layers(session)?) } else { None };
    if aov {
        super::solve::tell_estimate(session)?;
    }
    let times = session.sample_telling(&mut |done, all, steps| samples.tell(done, all, steps))?;
    phase("writing the picture", || match layers {
        Some(layers) => save(&session.picture()?, &layers, output),
        None => session.save(output),
    })?;
    Ok(times)
}

/// Parses `0..59`, both ends included; the output path must have a placeholder for the number.
pub fn parse(text: &str, output: &Path) -> Result<RangeInclusive<i32>> {
    let ends = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    let Some((first, last)) = ends.filter(|(a, b): &(i32, i32)| a <= b && i64::from(*b) - i64::from(*a) < MOST) else {
        let expected = "A..B, whole numbers, A at most B, both included, at most 1000000 frames";
        return Err(Input::new("not a range of frames").key("--frames").found(text).expected(expected).into());
    };
    if numbered(output, 0).is_none() {
        let fault = Input::new("every frame needs a file of its own").key("--output").found(output.display());
        return Err(fault.expected("the place of the frame's number, once: frame-%04d.png").into());
    }
    Ok(first..=last)
}

/// The file of a frame; none if its name has no placeholder for the number.
fn numbered(output: &Path, frame: i32) -> Option<PathBuf> {
    let name = numbered_text(&text_of_path(output.into()), frame.into())?;
    Some(path_of_text(Path::new(&name)).into_owned())
}

#[cfg(test)]
mod tests {
    use crate::cli::sequence::*;

    #[test]
    fn ranges_include_both_ends() {
        let output = Path::new("%d.png");
        assert_eq!(parse("0..59", output).unwrap(), 0..=59);
        assert_eq!(parse("-3..-3", output).unwrap(), -3..=-3);
        for bad in ["5", "5..", "..5", "5..4", "a..b", "0..99999999", "1..2.5"] {
            assert!(parse(bad, output).is_err(), "{bad}");
        }
        assert!(parse("0..1", Path::new("a.png")).is_err());
    }
}
