//! Anti-aliasing: a picture as the mean of pictures, each with its rays through another point of the pixels and of
//! the lens. Only stages that depend on the view run again; light transport does not.

use std::f64::consts::PI;

use super::frame_parts::FrameParts;
use super::run::Session;
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::{BufferId, Hit, NONE};
use crate::pipeline::plan::{Change, Changes};
use crate::view::picture::Picture;

/// Offset of sample `k` of `count` from the pixel's centre, in pixels: a golden-ratio lattice, one sample per column.
/// Its error at an edge is half that of the R2 sequence.
#[must_use]
pub fn place(k: u32, count: u32) -> [f64; 2] {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    [(f64::from(k) + 0.5) / f64::from(count) - 0.5, (0.5 + f64::from(k) * golden).fract() - 0.5]
}

/// Point of the lens for sample `k` of `count`, in radii from its middle: sunflower seeds, each with an equal part of
/// the area.
#[must_use]
pub fn lens(k: u32, count: u32) -> [f64; 2] {
    let radius = ((f64::from(k) + 0.5) / f64::from(count)).sqrt();
    let (sine, cosine) = (f64::from(k) * PI * (3.0 - 5f64.sqrt())).sin_cos();
    [radius * cosine, radius * sine]
}

impl Session {
    /// Runs the first frame of a picture, as [`Session::frame`] runs one: that of its first sample, which
    /// [`Session::sample`] goes on from. A frame through the pixels' centres is a sample only if it is the only one.
    pub fn first_sample(&mut self, change: Change) -> Result<Vec<Timing>> {
        if self.scene().camera.samples == 1 {
            return self.frame(change);
        }
        self.pending.add(change);
        self.sample_one(0)
    }

    /// Runs the frames of the camera's samples, all or those that are left, and in the first whatever has changed.
    /// Returns the times of their steps. Does nothing if there is one sample only.
    pub fn sample(&mut self) -> Result<Vec<Timing>> {
        self.sample_telling(&mut |_, _, _| ())
    }

    /// The same; after each sample `tell` gets the number of samples done, that of all, and the times of the steps of
    /// the last one.
    pub fn sample_telling(&mut self, tell: &mut dyn FnMut(u32, u32, &[Timing])) -> Result<Vec<Timing>> {
        let (samples, mut times) = (self.scene().camera.samples, Vec::new());
        if samples == 1 {
            return Ok(times);
        }
        let done = if self.pending == Changes::default() { self.samples_done } else { 0 };
        for k in done..samples {
            let steps = self.sample_one(k)?;
            tell(k + 1, samples, &steps);
            times.extend(steps);
        }
        Ok(times)
    }

    /// Runs the frame of sample `k`, after those of the samples before it; what is shown then is the mean of these. The
    /// camera has several samples.
    fn sample_one(&mut self, k: u32) -> Result<Vec<Timing>> {
        let frame = self.begin_sample(k)?;
        self.complete(frame)
    }

    /// Begins the frame of sample `k`, as [`Session::sample`] runs it; [`Session::go_on`] runs its steps.
    pub fn begin_sample(&mut self, k: u32) -> Result<FrameParts> {
        let samples = self.scene().camera.samples;
        self.shift(place(k, samples), lens(k, samples), k)?;
        let mut frame = self.begin_as_it_is(Change::VIEW)?;
        frame.sample = Some(k);
        Ok(frame)
    }

    /// Whether the mean over the camera's samples, if they are several, is complete.
    pub(super) fn sampled(&self) -> bool {
        self.samples_done > 0 && self.samples_done == self.scene().camera.samples
    }

    /// Counts which pixels of the sample that is done show an object, where pictures have a transparent background.
    pub(super) fn cover(&mut self) -> Result<()> {
        let several = self.scene().camera.transparent && self.scene().camera.samples > 1;
        let Some(sample) = self.state().data.camera.first().filter(|_| several).map(|camera| camera.sample_number)
        else {
            return Ok(());
        };
        self.fetch(&[BufferId::hits])?;
        let hits = &self.prepared.state.data.hits;
        if sample == 0 {
            self.coverage = vec![0; hits.len()];
        }
        let shows = |hit: &Hit| u8::from(hit.face != NONE);
        self.coverage.iter_mut().zip(hits).for_each(|(count, hit)| *count += shows(hit));
        Ok(())
    }

    /// The share of each pixel that shows an object; none unless the picture has a transparent background.
    pub(super) fn alpha(&self) -> Option<Vec<f32>> {
        let (camera, hits) = (&self.scene().camera, &self.state().data.hits);
        camera.transparent.then(|| match self.sampled() {
            true => self.coverage.iter().map(|&count| f32::from(count) / camera.samples as f32).collect(),
            false => hits.iter().map(|hit| f32::from(u8::from(hit.face != NONE))).collect(),
        })
    }
}

/// The picture of a session: that of its last frame, or the mean of the camera's several samples, with equal weights.
pub fn picture(session: &mut Session) -> Result<Picture> {
    session.sample()?;
    session.picture()
}

#[cfg(test)]
mod tests {
    use crate::pipeline::plan::Options;
    use crate::scene::Scene;
    use crate::session::antialiasing::*;

    #[test]
    fn a_picture_has_a_frame_a_sample_and_no_other() {
        let sets = ["object.0.detail=2", "camera.size=[12, 12]", "camera.samples=3"].map(str::to_string);
        let mut scene = Scene::load_with("sphere", &sets).unwrap();
        let mut session = Session::new(&scene, None, Options::default()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let frames = |steps: &[Timing]| steps.iter().filter(|step| step.name.starts_with("visibility")).count();
        assert_eq!(frames(&session.sample().unwrap()), 3, "rays through the centres are no sample");
        let wanted = session.picture().unwrap().pixels;
        assert_eq!(frames(&session.sample().unwrap()), 0, "the picture is done");

        let mut session = Session::new(&scene, None, Options::default()).unwrap();
        assert_eq!(frames(&session.first_sample(Change::EVERYTHING).unwrap()), 1);
        assert_eq!(frames(&session.sample().unwrap()), 2, "the first sample is not rendered again");
        assert_eq!(session.picture().unwrap().pixels, wanted);
        // What changes afterwards comes with the next first sample, the whole picture again.
        scene.lights.clear();
        session.show(&scene).unwrap();
        assert_eq!(frames(&session.sample().unwrap()), 3);
        assert!(session.picture().unwrap().pixels != wanted);
    }

    #[test]
    fn places_fill_the_pixel() {
        assert_eq!(place(0, 1), [0.0, 0.0]);
        let places: Vec<[f64; 2]> = (0..64).map(|k| place(k, 64)).collect();
        assert!(places.iter().flatten().all(|x| (-0.5..0.5).contains(x)));
        // The lens's points lie in the disc, and each quarter of it has 15 to 17.
        let lens: Vec<[f64; 2]> = (0..64).map(|k| lens(k, 64)).collect();
        assert!(lens.iter().all(|[x, y]| x.hypot(*y) < 1.0));
        for quarter in 0..4 {
            let inside = |p: &&[f64; 2]| usize::from(p[0] > 0.0) + 2 * usize::from(p[1] > 0.0) == quarter;
            assert!((15..=17).contains(&lens.iter().filter(inside).count()), "{quarter}");
        }
        // Each sixteenth of the pixel contains three to five of 64 samples, and their mean is near the centre.
        for cell in 0..16 {
            let inside = |p: &&[f64; 2]| ((p[0] + 0.5) * 4.0) as usize + 4 * ((p[1] + 0.5) * 4.0) as usize == cell;
            assert!((3..=5).contains(&places.iter().filter(inside).count()), "{cell}");
        }
        let mean = [0, 1].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / 64.0);
        assert!(mean.iter().all(|x| x.abs() < 0.02), "{mean:?}");
    }
}
