//! Textures: factors on light where it enters the material, or where it leaves.

use super::file::MaterialFile;
use super::files::Files;
use super::image::{MOST_TEXELS, clamp, read_exr, read_hdr, read_packed};
use super::locate;
use super::mesh::{Texels, map_kd, own_texture};
use super::object::Source;
use super::range::Checked;
use crate::error::Input;
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

mod wrap;

pub use wrap::Wrap;
pub(super) use wrap::Wraps;

/// Maximum texels along a side.
pub(super) const MOST_SIDE: u32 = 1 << 14;
/// The name that stands for the texture in the mesh's material library.
const LIBRARY: &str = "mtl";
/// The name that stands for the texture that the mesh file brings along.
const OWN: &str = "mesh";
/// Built-in checkerboards: name, and the two colours of the squares, linear.
const BUILTIN: [(&str, [[f32; 3]; 2]); 2] =
    [("builtin:checker", [[1.0; 3], [0.25; 3]]), ("builtin:tiles", [[0.9, 0.55, 0.2], [0.1, 0.35, 0.8]])];

/// Factors from 0 to 1 over a surface, r g b, linear.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Width and height, in texels, each from 1 to 16,384.
    pub size: [u32; 2],
    /// The texels, row by row from the top, each from 0 to 1; at most 2^23.
    pub texels: Arc<Vec<[f32; 3]>>,
    /// Where the factors apply.
    pub side: Side,
    /// How the texture continues beyond its left and right edges, and beyond its lower and upper ones.
    pub wrap: [Wrap; 2],
    /// The file that the texels are still to be read from, if any.
    image: Option<String>,
}

/// Where a texture's factors apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// To light that enters.
    Entry,
    /// To light that leaves.
    #[default]
    Exit,
    /// To both, each time by the square root of the texel.
    Both,
}

impl Texture {
    /// A texture of these texels, row by row from the top, that continues in the same way beyond all edges.
    pub fn new(size: [u32; 2], texels: Vec<[f32; 3]>, side: Side, wrap: Wrap) -> Self {
        Self { size, texels: Arc::new(texels), side, wrap: [wrap; 2], image: None }
    }

    /// Checks a material's texture keys, whose full names `key` gives; a file is read later.
    pub(super) fn check(file: &MaterialFile, key: impl Fn(&str) -> String) -> Checked<Option<Self>> {
        let Some(image) = &file.texture else {
            let wraps = file.texture_wrap.is_some() && file.sigma_0_texture.is_none();
            let given = [("texture_on", file.texture_on.is_some()), ("texture_wrap", wraps)];
            let idle = given.into_iter().find(|(_, given)| *given);
            return idle.map_or(Ok(None), |(name, _)| {
                let fault = Input::new("the material has no texture").key(key(name));
                Err(fault.expected("a `texture` beside it"))
            });
        };
        let (side, wrap) = (file.texture_on.unwrap_or_default(), file.texture_wrap.unwrap_or_default().0);
        Self::named(image, side, wrap, key("texture")).map(Some)
    }

    /// The same for the texture of sigma_0.
    pub(super) fn sigma_0(file: &MaterialFile, key: impl Fn(&str) -> String) -> Checked<Option<Self>> {
        let wrap = file.texture_wrap.unwrap_or_default().0;
        let draft = |image: &String| Self::named(image, Side::default(), wrap, key("sigma_0_texture"));
        file.sigma_0_texture.as_ref().map(draft).transpose()
    }

    fn named(image: &str, side: Side, wrap: [Wrap; 2], key: String) -> Checked<Self> {
        let built_in = BUILTIN.iter().find(|(name, _)| *name == image);
        if image.starts_with("builtin:") && built_in.is_none() {
            let names = BUILTIN.map(|(name, _)| name);
            let what = locate::with_suggestion("no texture of this name is built in", image, &names);
            return Err(Input::new(what).key(key).found(image).expected(names.join(", ")));
        }
        let made = match built_in {
            Some((_, colors)) => Self::new([64, 64], squares(*colors), side, wrap[0]),
            None => Self { image: Some(image.to_owned()), ..Self::new([0, 0], Vec::new(), side, wrap[0]) },
        };
        Ok(Self { wrap, ..made })
    }

    /// Whether it is the texture that the mesh file brings along, not read yet.
    pub(super) fn is_own(&self) -> bool {
        self.image.as_deref() == Some(OWN)
    }

    /// Reads the texels of a texture that is not built in: from its file, relative to `folder`, from the one that the
    /// mesh's material library names, or from the mesh file itself. What is left out or clamped is added to `report`.
    pub(super) fn load(
        &mut self,
        files: &Files,
        folder: &Path,
        mesh: &Source,
        key: &str,
        report: &mut Vec<String>,
    ) -> Checked<()> {
        let Some(image) = self.image.take() else { return Ok(()) };
        let path = match mesh {
            Source::File(mesh, part) if image == OWN => {
                let texels = own_texture(files, &folder.join(mesh), *part).map_err(|fault| at_key(fault, key))?;
                return self.set(checked(texels, key, &folder.join(mesh), report)?);
            }
            _ if image != LIBRARY && image != OWN => folder.join(&image),
            Source::File(mesh, _) => map_kd(files, &folder.join(mesh), report).map_err(|fault| at_key(fault, key))?,
            Source::Shape(..) => {
                let what = "a shape has neither a material library nor a texture of its own";
                let fault = Input::new(what).key(key).found(format!("`{image}`"));
                return Err(fault.expected("an image file, or the name of one that is built in"));
            }
        };
        self.set(read(files, &path, key, report)?)
    }

    fn set(&mut self, (size, texels): Texels) -> Checked<()> {
        (self.size, self.texels) = (size, Arc::new(texels));
        Ok(())
    }
}

/// Turns an error in another file into an error of a scene's key.
fn at_key(fault: Input, key: &str) -> Input {
    let line = fault.line.map_or(String::new(), |line| format!(":{line}"));
    let what = format!("{}{line}: {}", fault.file.display(), fault.what);
    Input { found: fault.found, expected: fault.expected, ..Input::new(what).key(key) }
}

/// 8 x 8 squares of 8 x 8 texels, the first colour at the top left.
fn squares(colors: [[f32; 3]; 2]) -> Vec<[f32; 3]> {
    (0..64 * 64).map(|place| colors[(place % 64 / 8 + place / 64 / 8) % 2]).collect()
}

/// Reads the size and texels of a file; `key` is the texture's key, for errors.
fn read(files: &Files, path: &Path, key: &str, report: &mut Vec<String>) -> Checked<Texels> {
    let at = |what: String| Input::new(what).key(key);
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
    let image = match end.as_str() {
        "png" | "jpg" | "jpeg" => read_packed(files, path),
        "exr" => read_exr(files, path, MOST_TEXELS, report),
        "hdr" => read_hdr(files, path, MOST_TEXELS),
        _ => {
            let fault = at("not the name of a texture".into()).found(path.display());
            let names = BUILTIN.map(|(name, _)| name).join(", ");
            return Err(
                fault.expected(format!("a file that ends in .png, .jpg, .exr or .hdr, {LIBRARY}, {OWN}, or {names}"))
            );
        }
    };
    let read = image.map_err(|error| at(format!("{}: the texture cannot be read", path.display())).found(error))?;
    checked(read, key, path, report)
}

/// Checks size and texels of the texture in a file.
fn checked((size, mut texels): Texels, key: &str, path: &Path, report: &mut Vec<String>) -> Checked<Texels> {
    let at = |what: String| Input::new(what).key(key);
    if texels.is_empty() || texels.len() > MOST_TEXELS || size.iter().any(|&side| side > MOST_SIDE) {
        let fault = at(format!("{}: the texture has too few or too many texels", path.display()));
        let found = format!("{} x {}", size[0], size[1]);
        return Err(fault.found(found).expected(format!("1 to {MOST_TEXELS} texels, at most {MOST_SIDE} a side")));
    }
    if let Err(place) = clamp(&mut texels, 3, 1.0, path, report) {
        let (x, y, [r, g, b]) = (place % size[0] as usize, place / size[0] as usize, texels[place]);
        let fault = at(format!("{}: texel ({x}, {y}), from the top left, is no albedo", path.display()));
        return Err(fault.found(format!("[{r}, {g}, {b}]")).expected("numbers from 0 to 1"));
    }
    Ok((size, texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_is_made_linear_and_exr_taken_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let pixel = |x: u32, y: u32| image::Rgb([(51 * (x + 2 * y)) as u8, 128, 255]);
        image::RgbImage::from_fn(2, 2, pixel).save(path("a.png")).expect("written");
        let pixel = |x: u32, y: u32| image::Luma([(13_107 * (x + 2 * y)) as u16]);
        image::ImageBuffer::from_fn(2, 2, pixel).save(path("b.png")).expect("written");
        exr::prelude::write_rgb_file(path("c.exr"), 2, 2, |x, y| (x as f32, 0.5 * y as f32, 0.25)).expect("written");
        let of = |name: &str| read(&Files::default(), &path(name), "texture", &mut Vec::new()).expect(name);
        // Linear values of sRGB 0.2, 0.4, 0.6 and 128 / 255 by the standard's formula.
        let light = [0.0, 0.033_104_8, 0.132_868_3, 0.318_546_8];
        for (name, others) in [("a.png", Some([0.215_860_5, 1.0])), ("b.png", None)] {
            let (size, texels) = of(name);
            assert_eq!(size, [2, 2]);
            for (texel, light) in texels.iter().zip(light) {
                let expected = others.map_or([light; 3], |[g, b]| [light, g, b]);
                assert!((0..3).all(|c| (texel[c] - expected[c]).abs() < 1e-6), "{name}: {texel:?}");
            }
        }
        assert_eq!(of("c.exr").1[3], [1.0, 0.5, 0.25]);
    }

    #[test]
    fn an_exr_whose_window_is_the_wrong_way_round_is_read_as_if_it_were_not() {
        // The exr crate reorders corners silently.
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        exr::prelude::write_rgb_file(path("a.exr"), 2, 2, |x, y| (x as f32, 0.5 * y as f32, 0.25)).expect("written");
        let mut bytes = std::fs::read(path("a.exr")).expect("bytes");
        let name = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = name.len() + bytes.windows(name.len()).position(|here| here == name).expect("a window");
        let window = bytes[at..at + 16].to_vec();
        bytes[at..at + 16].copy_from_slice(&[&window[8..], &window[..8]].concat());
        std::fs::write(path("b.exr"), bytes).expect("written");
        let of = |name: &str| read(&Files::default(), &path(name), "texture", &mut Vec::new()).expect(name);
        assert_eq!(of("a.exr"), of("b.exr"));
    }

    #[test]
    fn squares_alternate() {
        let texels = squares([[1.0; 3], [0.0; 3]]);
        assert_eq!(
            [0, 7, 8, 16, 8 * 64, 8 * 64 + 8, 4095].map(|place| texels[place][0]),
            [1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0]
        );
    }
}
