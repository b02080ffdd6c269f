//! Pictures on the page, and their perceptual difference: the mean of NVIDIA's FLIP (Andersson et al. 2020) at 67
//! pixels per degree, from 0 for equal to 1 for the largest difference.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip, magma_lut};

use super::html::Shown;
use super::whole::verdict;
use super::{Bench, Page};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::measure::table::Table;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{BUILTIN, Scene};
use crate::session::run::Session;
use crate::view::picture::Picture;

/// A picture with 8-bit channels.
pub struct Shot {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Eight bits per channel, sRGB.
    pub bytes: Vec<u8>,
    /// Milliseconds of the frame by the device's clock, or the host's on the CPU.
    pub ms: f64,
}

impl Shot {
    /// Applies a picture's exposure and tone curve.
    pub fn of(picture: &Picture, ms: f64) -> Self {
        Self { size: [picture.width as u32, picture.height as u32], bytes: picture.bytes(), ms }
    }

    /// Renders a scene on a device; `None` for the CPU.
    pub fn take(scene: &Scene, device: Option<&Device>, transport: ShadingMethod) -> Result<Self> {
        let options = Options { transport, ..Options::default() };
        let mut session = Session::new(scene, device, options)?;
        let times = session.frame(Change::EVERYTHING)?;
        let picture = session.picture()?;
        Ok(Self::of(&picture, times.iter().map(|time| time.milliseconds).sum()))
    }

    /// The picture for the page, with a caption.
    pub fn show(&self, label: impl Into<String>) -> Result<Shown> {
        Ok(Shown { label: label.into(), width: self.size[0], png: png(self.size, &self.bytes)? })
    }

    /// FLIP's mean error against a reference of the same size, and its map: black for equal, yellow for a large
    /// difference.
    pub fn apart(&self, reference: &Self) -> Result<(f64, Shot)> {
        if self.size != reference.size {
            return Err(Error::Check("pictures of different sizes can't be compared".into()));
        }
        let [width, height] = self.size;
        let image = |shot: &Self| FlipImageRgb8::with_data(width, height, &shot.bytes);
        let map = flip(image(reference), image(self), DEFAULT_PIXELS_PER_DEGREE);
        let mean = f64::from(FlipPool::from_image(&map).mean());
        let bytes = map.apply_color_lut(&magma_lut()).to_vec();
        Ok((mean, Self { size: self.size, bytes, ms: f64::NAN }))
    }
}

/// Encodes a PNG file.
pub fn png([width, height]: [u32; 2], bytes: &[u8]) -> Result<Vec<u8>> {
    let mut file = std::io::Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut file,
        bytes,
        width,
        height,
        image::ExtendedColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .map_err(|error| Error::Check(format!("a picture could not be made: {error}")))?;
    Ok(file.into_inner())
}

/// A built-in scene with a picture of this size, one sample per pixel.
pub fn scene(name: &str, [width, height]: [u32; 2], sets: &[&str]) -> Result<Scene> {
    let own = [format!("camera.size=[{width}, {height}]"), "camera.samples=1".into()];
    Scene::load_with(name, &own.into_iter().chain(sets.iter().map(|set| (*set).to_string())).collect::<Vec<_>>())
}

/// Maximum FLIP of two pictures that differ by rounding only; far below what is visible.
const SAME: f64 = 5e-3;

/// Number of triangles above which a quick report leaves a scene out.
const LARGE: usize = 50_000;

/// The scenes at the front of the page.
const FRONT: [&str; 4] = ["lotus", "candle", "torus", "veins"];

/// A picture for the front of the page, with several samples per pixel.
fn front(bench: &Bench<'_>, name: &str) -> Result<Shown> {
    let (side, samples) = bench.either((240, 4), (288, 16));
    let sets = [format!("camera.size=[{side}, {side}]"), format!("camera.samples={samples}")];
    let scene = Scene::load_with(name, &sets)?;
    let picture = Session::new(&scene, bench.device, Options::default())?.render()?;
    let about = BUILTIN.iter().find(|(known, ..)| *known == name).map_or("", |(_, _, about)| *about);
    Shot::of(&picture, f64::NAN).show(format!("{name}: {about}"))
}

/// Every built-in scene by the device and by the CPU reference, and their difference.
pub fn scenes(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let side = bench.either(144, 240);
    let shown = FRONT.iter().map(|name| front(bench, name)).collect::<Result<Vec<_>>>()?;
    page.to_front(|page| page.pictures(&shown));
    page.say("FLIP is the mean of NVIDIA's perceptual difference, 0 to 1, beside its map: black where two pictures are the same.");
    let (mut rows, mut worst, mut left) = (Vec::new(), 0.0f64, Vec::new());
    for (name, _, about) in BUILTIN {
        let scene = scene(name, [side; 2], &[])?;
        if bench.quick && scene.objects.iter().map(|object| object.mesh.triangles.len()).sum::<usize>() > LARGE {
            left.push(*name);
            continue;
        }
        let reference = Shot::take(&scene, None, ShadingMethod::Hierarchy)?;
        page.head(&format!("{name}: {about}"));
        let Some(device) = bench.device else {
            page.pictures(&[reference.show("CPU reference, f64")?]);
            continue;
        };
        let found = Shot::take(&scene, Some(device), ShadingMethod::Hierarchy)?;
        let (mean, map) = found.apart(&reference)?;
        worst = worst.max(mean);
        let steps = found.bytes.iter().zip(&reference.bytes).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        page.pictures(&[
            found.show(device.name())?,
            reference.show("CPU reference, f64")?,
            map.show(format!("difference, FLIP {mean:.1e}"))?,
        ]);
        rows.push(vec![
            (*name).to_string(),
            format!("{mean:.1e}"),
            steps.to_string(),
            format!("{:.1}", found.ms),
            format!("{:.1}", reference.ms),
        ]);
        if mean > SAME {
            page.fail(&format!(
                "{name}: the device's picture is FLIP {mean:.1e} from the reference, beyond {SAME:.0e}"
            ));
        }
    }
    if !left.is_empty() {
        page.say(&format!("Left out, for they take the CPU long: {}. The full report has them.", left.join(", ")));
    }
    if rows.is_empty() {
        return Ok(());
    }
    let columns = [
        ("scene", ""),
        ("FLIP", "perceptual difference of the device's picture from the CPU's: 0 is equal, 1 the largest difference"),
        ("largest step of 255", "largest difference of an 8-bit channel"),
        ("device, ms", "time of the frame on the device"),
        ("CPU, ms", "time of the frame by the CPU reference"),
    ];
    let about = format!("{} pictures on the device, at most FLIP {worst:.0e} from the CPU's", rows.len());
    page.table("pictures", &Table::new(columns, rows))?;
    verdict(page, "Same pictures", &about);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flip_sees_what_differs() {
        let shot = |level: fn(u32) -> u8| Shot {
            size: [32, 24],
            bytes: (0..32 * 24).flat_map(|i| [level(i); 3]).collect(),
            ms: 0.0,
        };
        let (grey, other) = (shot(|i| (i % 32) as u8 * 7), shot(|i| (i % 32) as u8 * 7 + if i > 380 { 30 } else { 0 }));
        let (same, black) = grey.apart(&grey).unwrap();
        let (apart, map) = other.apart(&grey).unwrap();
        assert!(same == 0.0 && (0.01..0.5).contains(&apart), "{same} {apart}");
        assert!(black.bytes.iter().all(|byte| *byte < 6) && map.bytes.iter().any(|byte| *byte > 60));
        assert!(grey.show("grey").unwrap().png.starts_with(b"\x89PNG"));
        assert!(grey.apart(&Shot { size: [24, 32], ..shot(|_| 0) }).is_err());
    }
}
