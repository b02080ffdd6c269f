//! What tints a part: an image, the colours of its vertices, or one colour.

use super::assembly::Placed;
use super::document::{Document, gone, source};
use super::primitive;
use super::{Assembly, Checked, Files, Input, Local, Parts, Texels, Tree, colors};
use crate::scene::image::unpack;
use gltf::json::Index;
use gltf::json::material::Material;
use gltf::json::mesh::Semantic;
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked::Valid;
use std::path::Path;

/// The tint of a part, with a factor, r g b, linear.
pub(super) enum Tint<'a> {
    /// An image.
    Image(&'a Info, [f64; 3]),
    /// The colours of the vertices.
    Colors([f64; 3]),
    /// One colour.
    Plain([f64; 3]),
}

impl<'a> Tint<'a> {
    /// The tint of the only part that is chosen.
    pub fn of(document: &'a Document, tree: &Tree, parts: &Parts) -> Checked<Self> {
        let [material] = parts.chosen[..] else {
            let fault = Input::new("the parts of the mesh have textures of their own").found("no `part`");
            return Err(fault.expected(format!("part = 0 to {}", parts.all.len() - 1)));
        };
        let Some(Material { pbr_metallic_roughness: pbr, .. }) = material.map(|index| &document.root.materials[index])
        else {
            return Self::without_image(document, tree, material, [1.0; 3]);
        };
        let factor = [0, 1, 2].map(|k| f64::from(pbr.base_color_factor.0[k]).clamp(0.0, 1.0));
        match pbr.base_color_texture.as_ref().filter(|info| is_read(document, info)) {
            Some(info) => Ok(Self::Image(info, factor)),
            None => Self::without_image(document, tree, material, factor),
        }
    }

    fn without_image(document: &Document, tree: &Tree, material: Option<usize>, factor: [f64; 3]) -> Checked<Self> {
        Ok(if is_colored(document, tree, material)? { Self::Colors(factor) } else { Self::Plain(factor) })
    }

    /// Words for the part of a material's colours that this tint leaves out, if any.
    pub fn left_out(&self, document: &Document, tree: &Tree, material: usize) -> Checked<Option<&'static str>> {
        let pbr = &document.root.materials[material].pbr_metallic_roughness;
        Ok(match self {
            Self::Image(..) if is_colored(document, tree, Some(material))? => {
                Some("the colours of its vertices, COLOR_0, are left out beside its texture")
            }
            Self::Colors(_) | Self::Plain(_) if pbr.base_color_texture.is_some() => {
                Some("its texture is left out: its image is neither PNG nor JPEG")
            }
            _ => None,
        })
    }

    /// Whether it changes anything.
    pub fn matters(&self) -> bool {
        !matches!(self, Self::Plain([1.0, 1.0, 1.0]))
    }

    /// The scene's words for how the texture continues beyond its edges, along u and along v.
    pub fn wrap(&self, document: &Document) -> [&'static str; 2] {
        let sampler = match self {
            Self::Image(info, _) => document.root.textures.get(info.index.value()).and_then(|texture| texture.sampler),
            _ => None,
        };
        let sampler = sampler.and_then(|sampler| document.root.samplers.get(sampler.value()));
        let modes = sampler.map_or([Valid(WrappingMode::Repeat); 2], |sampler| [sampler.wrap_s, sampler.wrap_t]);
        modes.map(|mode| match mode {
            Valid(WrappingMode::ClampToEdge) => "clamp",
            Valid(WrappingMode::MirroredRepeat) => "mirror",
            _ => "repeat",
        })
    }

    /// Texture coordinates of the corners of all triangles.
    pub fn corners(&self, document: &Document, files: &Files, assembly: &Assembly<'_>) -> Checked<Vec<[[f64; 2]; 3]>> {
        let count = assembly.triangles.len();
        Ok(match self {
            Self::Image(info, _) => {
                // Without texture coordinates the whole part has the colour of one texel.
                assembly.uvs(document, files, Some(info))?.unwrap_or_else(|| vec![[[0.0; 2]; 3]; count])
            }
            Self::Colors(_) => colors::corners(count),
            Self::Plain(_) => vec![[[0.5; 2]; 3]; count],
        })
    }

    /// The texture; its image is beside `path`.
    pub fn texels(
        &self,
        document: &Document,
        files: &Files,
        path: &Path,
        tree: &Tree,
        parts: &Parts,
    ) -> Checked<Texels> {
        let times = |color: [f32; 3], factor: &[f64; 3]| [0, 1, 2].map(|k| color[k] * factor[k] as f32);
        match self {
            Self::Plain(factor) => Ok(([1, 1], vec![times([1.0; 3], factor)])),
            Self::Colors(factor) => {
                let locals = Local::rest(document);
                let assembly = Assembly::of(document, files, tree, &locals, &parts.chosen)?;
                let mut all = vec![[1.0; 3]; assembly.base.len()];
                for Placed { primitive, first, .. } in &assembly.pieces {
                    let colors_of_piece = primitive::colors(document, files, primitive)?.unwrap_or_default();
                    all.iter_mut().skip(*first as usize).zip(colors_of_piece).for_each(|(place, color)| *place = color);
                }
                let tinted = |corners: &[u32; 3]| corners.map(|corner| times(all[corner as usize], factor));
                colors::checked(assembly.triangles.iter().map(tinted))
            }
            Self::Image(info, factor) => {
                let index = info.index.value();
                let texture = document.root.textures.get(index).ok_or_else(|| gone("texture", index))?;
                let bytes = image(document, files, path, texture.source)?;
                let fault =
                    |error: String| Input::new("an image cannot be read").key(format!("textures.{index}")).found(error);
                let (size, mut texels) = unpack(files, &bytes).map_err(fault)?;
                texels.iter_mut().for_each(|texel| *texel = times(*texel, factor));
                Ok((size, texels))
            }
        }
    }
}

/// Whether the vertices of a primitive with this material have colours.
fn is_colored(document: &Document, tree: &Tree, material: Option<usize>) -> Checked<bool> {
    Ok(super::assembly::primitives(document, tree)?.iter().any(|(_, primitive)| {
        let made_of_it = primitive.material.map(|material| material.value()) == material;
        made_of_it && primitive.attributes.contains_key(&Valid(Semantic::Colors(0)))
    }))
}

/// Whether a texture has an image in a format that is read, as far as the file says so.
fn is_read(document: &Document, info: &Info) -> bool {
    let Some(texture) = document.root.textures.get(info.index.value()) else { return true };
    // An image of another format comes with an extension, which names it instead.
    if texture.source.value() == u32::MAX as usize {
        return false;
    }
    let Some(image) = document.root.images.get(texture.source.value()) else { return true };
    let kind = image.mime_type.as_ref().map_or("", |kind| kind.0.as_str());
    let uri = image.uri.as_deref().unwrap_or_default();
    let other = ["webp", "ktx2", "avif", "vnd-ms.dds"].iter().any(|other| {
        let end = other.rsplit('.').next().unwrap_or_default();
        kind == format!("image/{other}")
            || uri.starts_with(&format!("data:image/{other};"))
            || Path::new(uri).extension().is_some_and(|own| own.eq_ignore_ascii_case(end))
    });
    !other
}

/// The bytes of an image.
fn image(document: &Document, files: &Files, path: &Path, index: Index<gltf::json::Image>) -> Checked<Vec<u8>> {
    let Some(image) = document.root.images.get(index.value()) else {
        let fault = Input::new("a texture has no image that can be read");
        return Err(fault.expected("a PNG or JPEG; other formats come with extensions that are not supported"));
    };
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => source(files, path, uri).map_err(|fault| fault.key(format!("images.{}", index.value()))),
        (None, Some(view)) => Ok(document.view(view)?.0.to_vec()),
        (None, None) => {
            Err(Input::new("an image has neither a source nor a buffer view").key(format!("images.{}", index.value())))
        }
    }
}
