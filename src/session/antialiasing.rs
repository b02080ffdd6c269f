//! Anti-aliasing: a picture as the mean of pictures, each with its rays through another point of the pixels. Only
//! stages that depend on the view run again; light transport does not.

use super::run::Session;
use crate::error::Result;
use crate::gpu::Timing;
use crate::pipeline::plan::Change;
use crate::view::picture::Picture;

/// Offset of sample `k` of `count` from the pixel's centre, in pixels: a golden-ratio lattice, one sample per column.
/// Its error at an edge is half that of the R2 sequence.
#[must_use]
pub fn place(k: u32, count: u32) -> [f64; 2] {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    [(f64::from(k) + 0.5) / f64::from(count) - 0.5, (0.5 + f64::from(k) * golden).fract() - 0.5]
}

/// The picture of a session, after a frame through the pixels' centres: the mean of the camera's number of samples,
/// with equal weights. The centre is a sample only if it is the only one. Leaves the session at the last sample.
pub fn picture(session: &mut Session) -> Result<Picture> {
    timed_picture(session).map(|(picture, _)| picture)
}

/// The same, with the times of the steps that ran for the samples: none for a single one.
pub fn timed_picture(session: &mut Session) -> Result<(Picture, Vec<Timing>)> {
    let (mut picture, mut times) = (session.picture()?, Vec::new());
    let samples = session.scene().camera.samples;
    if samples == 1 {
        return Ok((picture, times));
    }
    let mut sums = vec![[0.0; 3]; picture.pixels.len()];
    for k in 0..samples {
        session.shift(place(k, samples))?;
        times.extend(session.frame(Change::VIEW)?);
        for (sum, pixel) in sums.iter_mut().zip(&session.picture()?.pixels) {
            *sum = std::array::from_fn(|c| sum[c] + f64::from(pixel[c]));
        }
    }
    picture.pixels = sums.iter().map(|sum| sum.map(|x| (x / f64::from(samples)) as f32)).collect();
    Ok((picture, times))
}

#[cfg(test)]
mod tests {
    use crate::session::antialiasing::*;

    #[test]
    fn places_fill_the_pixel() {
        assert_eq!(place(0, 1), [0.0, 0.0]);
        let places: Vec<[f64; 2]> = (0..64).map(|k| place(k, 64)).collect();
        assert!(places.iter().flatten().all(|x| (-0.5..0.5).contains(x)));
        // Each sixteenth of the pixel contains three to five of 64 samples, and their mean is near the centre.
        for cell in 0..16 {
            let inside = |p: &&[f64; 2]| ((p[0] + 0.5) * 4.0) as usize + 4 * ((p[1] + 0.5) * 4.0) as usize == cell;
            assert!((3..=5).contains(&places.iter().filter(inside).count()), "{cell}");
        }
        let mean = [0, 1].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / 64.0);
        assert!(mean.iter().all(|x| x.abs() < 0.02), "{mean:?}");
    }
}
