//! Anti-aliasing: a picture as the mean of pictures, each with its rays through another point of the pixels and of
//! the lens. Only stages that depend on the view run again; light transport does not.

use std::f64::consts::PI;

use super::frame_parts::FrameParts;
use super::run::Session;
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::{BufferId, Hit, NONE};
use crate::pipeline::plan::Change;
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
    /// Runs the frames of the camera's samples, after one through the pixels' centres, which is a sample only if it is
    /// the only one. Returns the times of their steps. Does nothing if that is done and nothing has changed since.
    pub fn sample(&mut self) -> Result<Vec<Timing>> {
        self.sample_telling(&mut |_, _, _| ())
    }

    /// The same; after each sample `tell` gets the number of samples done, that of all, and the times of the steps of
    /// the last one.
    pub fn sample_telling(&mut self, tell: &mut dyn FnMut(u32, u32, &[Timing])) -> Result<Vec<Timing>> {
        let (samples, mut times) = (self.scene().camera.samples, Vec::new());
        if samples == 1 || self.sampled {
            return Ok(times);
        }
        for k in 0..samples {
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
        frame.last_sample = k + 1 == samples;
        Ok(frame)
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
        camera.transparent.then(|| match self.sampled {
            true => self.coverage.iter().map(|&count| f32::from(count) / camera.samples as f32).collect(),
            false => hits.iter().map(|hit| f32::from(u8::from(hit.face != NONE))).collect(),
        })
    }
}

/// The picture of a session, after a frame through the pixels' centres: the mean of the camera's number of samples,
/// with equal weights.
pub fn picture(session: &mut Session) -> Result<Picture> {
    session.sample()?;
    session.picture()
}

#[cfg(test)]
mod tests {
    use crate::session::antialiasing::*;

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
