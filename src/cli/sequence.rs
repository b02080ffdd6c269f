//! `milkglass render --frames` and `--turntable`: one picture per frame, the same as if each were rendered alone, but
//! for a metered exposure, which is that of frame 0. A GIF holds all of them.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};

use super::bare::Subject;
use super::long_work::tell_long_work;
use super::samples::Samples;
use super::{check_messages, open_session, run_first_sample, run_frame};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, Timing};
use milkglass::internals::phases::phase;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::prepare::shape::turned;
use milkglass::internals::session::aov::layers;
use milkglass::internals::session::run::Session;
use milkglass::internals::view::aov::save;
use milkglass::internals::view::film::{Film, is_gif};
use milkglass::scene::{Scene, numbered as numbered_text, path_of_text, text_of_path};

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
    /// The output path: of a GIF, or with a placeholder for the number.
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
        let gif = is_gif(self.output);
        let start = Instant::now();
        let output = |frame: i32| numbered(self.output, frame).unwrap_or_default();
        // Only a non-empty file counts as a picture.
        let whole = |path: &Path| path.metadata().is_ok_and(|known| known.is_file() && known.len() > 0);
        let skips = |frame: &i32| self.skip && whole(&output(*frame));
        let (left_out, wanted): (Vec<i32>, Vec<i32>) = self.frames.clone().partition(skips);
        let mut size = self.size;
        wanted.iter().try_for_each(|&frame| {
            let told = |_: &Error| tell!("the scene is not valid at frame {frame}; nothing was rendered");
            let found = self.scenes.check(f64::from(frame)).inspect_err(told)?;
            let before = *size.get_or_insert(found);
            let same = if gif && self.size.is_none() { Film::check_sizes(before, found) } else { Ok(()) };
            same.inspect_err(told).map_err(|error| match self.scene(frame) {
                Ok(scene) => scene.placed(error),
                Err(_) => error,
            })
        })?;
        let bar = ProgressBar::new(wanted.len() as u64);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} frames, {eta} left") {
            bar.set_style(style);
        }
        let (mut session, mut film) = (self.metered(device)?, None);
        for (done, &frame) in wanted.iter().enumerate() {
            let session = self.prepare(device, &mut session, &bar, frame);
            let done_with = session.and_then(|session| {
                if gif {
                    self.film(device, session, &mut film)
                } else {
                    shoot(session, self.aov, &output(frame), Samples::hidden()).map(drop)
                }
            });
            if let Err(error) = done_with.and_then(|()| check_messages(device)) {
                bar.finish_and_clear();
                tell!("frame {frame} failed, after {done} others; {}", self.left(film, frame));
                return Err(error);
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        film.map(|film| film.save(None)).transpose()?;
        let place = device.map_or("the CPU", |device| device.name());
        let (count, there) = (wanted.len(), left_out.len());
        let there = if there > 0 { format!(", {there} were there") } else { String::new() };
        let seconds = start.elapsed().as_secs_f64();
        tell!("{count} frames{there}, on {place}, {seconds:.1} s");
        Ok(())
    }
}

impl Job<'_> {
    /// What is left of the frames before one that failed: those of a film get a file of their own.
    fn left(&self, film: Option<Film>, failed: i32) -> String {
        let name = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{name}.{}-{}.gif", self.frames.start(), failed - 1);
        match film.filter(|_| failed > *self.frames.start()).map(|film| film.save(Some(&name))) {
            None if is_gif(self.output) => "nothing was written".into(),
            None => "they are whole, and --skip-existing goes on from here".into(),
            Some(Ok(Some(place))) => format!("they are in {}", place.display()),
            Some(Ok(None)) => format!("they went to {}", self.output.display()),
            Some(Err(error)) => format!("they are lost: {error}"),
        }
    }

    /// Computes the light of a frame; the session is opened if it is none yet.
    fn prepare<'s>(
        &self,
        device: Option<&Device>,
        session: &'s mut Option<Session>,
        bar: &ProgressBar,
        frame: i32,
    ) -> Result<&'s mut Session> {
        let scene = self.scene(frame)?;
        let session = match session {
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
        // Layers belong to rays through the pixels' centres.
        let first = if self.aov { run_frame } else { run_first_sample };
        first(session, Change::default())?;
        check_messages(device)?;
        Ok(session)
    }

    /// The scene at a frame, with the pictures' size.
    fn scene(&self, frame: i32) -> Result<Scene> {
        let mut scene = self.scenes.at(f64::from(frame))?;
        scene.camera = scene.camera.clone().sized(self.size.unwrap_or(scene.camera.size))?;
        if is_gif(self.output) {
            Film::check(&scene.camera).map_err(|error| scene.placed(error))?;
        } else {
            scene.report.extend(scene.idle_fps()?);
        }
        Ok(scene)
    }

    /// Adds the picture of the last frame to the film, which it begins if there is none yet.
    fn film(&self, device: Option<&Device>, session: &mut Session, film: &mut Option<Film>) -> Result<()> {
        session.sample()?;
        let (bytes, scene) = (session.shown()?, session.scene());
        check_messages(device)?;
        let size = scene.camera.size;
        let film = match film {
            Some(film) => film,
            None => film.insert(Film::new(self.output, size, scene.fps)?),
        };
        film.push(size, &bytes).map_err(|error| scene.placed(error))
    }

    /// For a film whose camera is metered, a session that has found the exposure from frame 0, or else from the first
    /// frame of the range, so that films rendered in parts have one exposure; none for any other film.
    fn metered(&self, device: Option<&Device>) -> Result<Option<Session>> {
        let at = |frame: i32| self.scenes.check(frame.into()).and_then(|_| self.scene(frame));
        let Some(scene) = at(0).or_else(|_| at(*self.frames.start())).ok().filter(|scene| scene.camera.metered) else {
            return Ok(None);
        };
        scene.report.iter().for_each(|line| tell!("{line}"));
        let mut session = open_session(&scene, device, self.options)?;
        tell_long_work(&session);
        run_first_sample(&mut session, Change::default())?;
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
    // Layers first: they belong to the frame before the samples.
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
    if is_gif(output) && numbered(output, 0).is_some() {
        let fault = Input::new("a GIF holds all frames").key("--output").found(output.display());
        return Err(fault.expected("one name: NAME.gif; or NAME-%04d.png for a file each").into());
    }
    if !is_gif(output) && numbered(output, 0).is_none() {
        let fault = Input::new("every frame needs a file of its own").key("--output").found(output.display());
        return Err(fault.expected("the place of the frame's number, once: frame-%04d.png; or NAME.gif").into());
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
        assert!(parse("0..1", Path::new("a.png")).is_err() && parse("0..1", Path::new("a.gif")).is_ok());
        assert!(parse("0..1", Path::new("a-%02d.gif")).is_err());
    }
}
