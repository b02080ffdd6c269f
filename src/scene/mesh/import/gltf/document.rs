//! A glTF 2.0 file in memory: its JSON, its buffers, and the numbers that accessors find in them.
//!
//! The crate `gltf` parses JSON and GLB. Its own iterators over accessors trust counts and offsets, so that the numbers
//! are read here, with every index and length checked.

use super::super::unread;
use super::parse::{another, not_gltf, parse};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::Glb;
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked::Valid;
use gltf::json::{Index, Root, Value, buffer::View};
use percent_encoding::percent_decode_str;
use std::path::Path;

/// Memory of the parsed JSON per bracket and comma of its text, bytes: an empty object in a list is the worst.
const BYTES: u64 = 500;

/// Extensions whose meshes are compressed, which is not supported.
const COMPRESSED: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Extensions of textures whose images are not read; a texture that has no other image is left out.
const IMAGES: [&str; 4] = ["EXT_texture_avif", "EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"];

/// Extensions that are read.
const KNOWN: [&str; 8] = [
    "KHR_lights_punctual",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A file's JSON and buffers.
pub(super) struct Document {
    /// The JSON.
    pub root: Root,
    /// The bytes of each buffer; none for one without a source, such as the fallback of a compressed one.
    buffers: Vec<Option<Vec<u8>>>,
}

/// The error for a mesh, or a part of it, that exists in compressed form only.
fn compressed(name: &str) -> Input {
    let fault = Input::new("compressed meshes are not supported").found(name);
    fault.expected("glTF without mesh compression, such as `gltf-transform copy` writes")
}

/// The error for an index beyond its list.
pub(super) fn gone(what: &str, index: usize) -> Input {
    Input::new(format!("there is no {what} {index}"))
}

/// The value of an object's extension, if it has this one.
macro_rules! extension {
    ($object:expr, $name:expr) => {
        $object.extensions.as_ref().and_then(|all| all.others.get($name))
    };
}
pub(super) use extension;

/// A number of an extension, or its default.
pub(super) fn number(value: Option<&Value>, name: &str, usual: f64) -> f64 {
    value.and_then(|value| value.get(name)).and_then(Value::as_f64).unwrap_or(usual)
}

/// Numbers of an extension, or their default.
pub(super) fn numbers<const N: usize>(value: Option<&Value>, name: &str, usual: [f64; N]) -> [f64; N] {
    let list = value.and_then(|value| value.get(name)).and_then(Value::as_array);
    std::array::from_fn(|k| list.and_then(|list| list.get(k)).and_then(Value::as_f64).unwrap_or(usual[k]))
}

impl Document {
    /// Parses a file's bytes and reads its buffers, which are beside `path`.
    pub fn open(files: &Files, path: &Path, bytes: &[u8]) -> Checked<Self> {
        // The parser subtracts the header's 12 bytes from the length.
        let (text, blob) = match bytes.strip_prefix(b"glTF") {
            Some([1, 0, 0, 0, ..]) => return Err(another("1")),
            Some(rest) if rest.get(4..8).is_none_or(|length| length < &[12, 0, 0, 0][..] && length[1..] == [0; 3]) => {
                return Err(not_gltf("a header that is cut off"));
            }
            Some(_) => {
                let glb = Glb::from_slice(bytes).map_err(|error| not_gltf(&error.to_string()))?;
                (glb.json, glb.bin)
            }
            None => (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).into(), None),
        };
        let places = text.iter().filter(|byte| b"{[,".contains(byte)).count() as u64;
        files.need(places * BYTES + 2 * bytes.len() as u64).map_err(|error| unread(&error))?;
        let root = parse(&text, !bytes.starts_with(b"glTF"))?;
        for name in root.extensions_required.iter().map(String::as_str) {
            if COMPRESSED.contains(&name) {
                return Err(compressed(name));
            }
            if !KNOWN.contains(&name) && !IMAGES.contains(&name) {
                let fault = Input::new("the file requires an extension that is not known").found(name);
                return Err(fault.expected(format!("no other than {}", KNOWN.join(", "))));
            }
        }
        let mut document = Self { root, buffers: Vec::new() };
        let mut total = 0;
        for (index, buffer) in document.root.buffers.iter().enumerate() {
            let bytes = match (&buffer.uri, &blob) {
                (Some(uri), _) => {
                    Some(source(files, path, uri).map_err(|fault| fault.key(format!("buffers.{index}")))?)
                }
                (None, Some(blob)) if index == 0 => Some(blob.to_vec()),
                _ => None,
            };
            total += bytes.as_ref().map_or(0, Vec::len) as u64;
            files.need(total).map_err(|error| unread(&error))?;
            document.buffers.push(bytes);
        }
        Ok(document)
    }

    /// A line that lists the extensions which are ignored, if there are any.
    pub fn ignored(&self) -> Option<String> {
        let all = self.root.extensions_used.iter().chain(&self.root.extensions_required);
        let mut names: Vec<&str> = all.map(String::as_str).filter(|name| !KNOWN.contains(name)).collect();
        names.sort_unstable();
        names.dedup();
        (!names.is_empty()).then(|| format!("ignored: glTF extensions {}", names.join(", ")))
    }

    /// Fails if a primitive has its numbers in compressed form only: its accessors do not say where they are.
    pub fn check_plain(&self, primitive: &Primitive) -> Checked<()> {
        let name = COMPRESSED.into_iter().find(|name| extension!(primitive, *name).is_some());
        let mut accessors = primitive.attributes.values().chain(&primitive.indices).map(|index| index.value());
        let empty = |index: usize| {
            let accessor = self.root.accessors.get(index);
            accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
        };
        match name {
            Some(name) if accessors.any(empty) => Err(compressed(name)),
            _ => Ok(()),
        }
    }

    /// The bytes of a buffer view, and its stride.
    pub fn view(&self, index: Index<View>) -> Checked<(&[u8], Option<usize>)> {
        let fault = |what| Err(Input::new(what).key(format!("bufferViews.{}", index.value())));
        let Some(view) = self.root.buffer_views.get(index.value()) else {
            return Err(gone("buffer view", index.value()));
        };
        let Some(Some(bytes)) = self.buffers.get(view.buffer.value()) else {
            // A compressed view may name a buffer that has no bytes.
            let packed = COMPRESSED.into_iter().find(|name| extension!(view, *name).is_some());
            return packed.map_or_else(|| fault("its buffer has no bytes"), |name| Err(compressed(name)));
        };
        let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).unwrap_or(usize::MAX);
        let length = usize::try_from(view.byte_length.0).unwrap_or(usize::MAX);
        match bytes.get(start..start.saturating_add(length)) {
            Some(bytes) => Ok((bytes, view.byte_stride.map(|stride| stride.0))),
            None => fault("it reaches beyond its buffer"),
        }
    }

    /// All numbers of an accessor, and how many are in an element, one of `widths`.
    pub fn numbers(&self, files: &Files, index: usize, widths: &[usize]) -> Checked<(Vec<f64>, usize)> {
        let Some(accessor) = self.root.accessors.get(index) else { return Err(gone("accessor", index)) };
        let fault = |what: &str| Input::new(what).key(format!("accessors.{index}"));
        let (Valid(kind), Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return Err(fault("its type is not one of glTF's"));
        };
        let (kind, width) = (kind.0, shape.multiplicity());
        if !widths.contains(&width) {
            let fault = fault("an element has not as many numbers as it should").found(width);
            return Err(fault.expected(widths.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ")));
        }
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let total = count.saturating_mul(width);
        files.need((total as u64).saturating_mul(16)).map_err(|error| unread(&error))?;
        let read = |view, offset, count: usize, kind| {
            let (bytes, stride) = self.view(view)?;
            let offset = usize::try_from(offset).unwrap_or(usize::MAX);
            decode(bytes, [offset, count, width], stride, kind, accessor.normalized)
                .ok_or_else(|| fault("it reaches beyond its buffer view"))
        };
        let mut values = match accessor.buffer_view {
            Some(view) => read(view, accessor.byte_offset.map_or(0, |offset| offset.0), count, kind)?,
            None => vec![0.0; total],
        };
        if let Some(sparse) = &accessor.sparse {
            let Valid(of_index) = sparse.indices.component_type else {
                return Err(fault("its type is not one of glTF's"));
            };
            let changes = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let (bytes, _) = self.view(sparse.indices.buffer_view)?;
            let offset = usize::try_from(sparse.indices.byte_offset.0).unwrap_or(usize::MAX);
            let places = decode(bytes, [offset, changes, 1], None, of_index.0, false)
                .ok_or_else(|| fault("its sparse indices reach beyond their buffer view"))?;
            let others = read(sparse.values.buffer_view, sparse.values.byte_offset.0, changes, kind)?;
            for (place, other) in places.iter().zip(others.chunks_exact(width)) {
                let start = *place as usize * width;
                let Some(here) = values.get_mut(start..start + width) else {
                    return Err(fault("a sparse index is beyond its elements").found(place));
                };
                here.copy_from_slice(other);
            }
        }
        Ok((values, width))
    }

    /// The elements of an accessor of `N` numbers each.
    pub fn vectors<const N: usize>(&self, files: &Files, index: usize) -> Checked<Vec<[f64; N]>> {
        Ok(self.numbers(files, index, &[N])?.0.as_chunks().0.to_vec())
    }
}

/// Reads a URI: base64 in itself, or a file beside `path`.
pub(super) fn source(files: &Files, path: &Path, uri: &str) -> Checked<Vec<u8>> {
    if let Some(data) = uri.strip_prefix("data:") {
        let fault =
            |found: String| Input::new("its data cannot be read").found(found).expected("`data:...;base64,...`");
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(fault(data.chars().take(40).collect()));
        };
        files.need(text.len() as u64).map_err(|error| unread(&error))?;
        return BASE64_STANDARD.decode(text).map_err(|error| fault(error.to_string()));
    }
    if uri.contains("://") {
        return Err(Input::new("only files beside the mesh are read").found(uri).expected("the name of a file"));
    }
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let file = path.parent().unwrap_or(Path::new("")).join(name.as_ref());
    files
        .read(&file, 2)
        .map_err(|error| Input::new("its file cannot be read").found(format!("{}: {error}", file.display())))
}

/// `count` elements of `width` numbers each, from `offset` on; none if they reach beyond the bytes.
fn decode(
    bytes: &[u8],
    [offset, count, width]: [usize; 3],
    stride: Option<usize>,
    kind: ComponentType,
    normalized: bool,
) -> Option<Vec<f64>> {
    let size = kind.size();
    let element = size * width;
    let stride = stride.filter(|stride| *stride > 0).unwrap_or(element);
    let Some(last) = count.checked_sub(1) else { return Some(Vec::new()) };
    let end = last.checked_mul(stride)?.checked_add(offset)?.checked_add(element)?;
    let bytes = bytes.get(offset..end)?;
    let mut values = Vec::with_capacity(count * width);
    for first in (0..count).map(|k| k * stride) {
        for number in bytes[first..first + element].chunks_exact(size) {
            let number: [u8; 4] = std::array::from_fn(|k| number.get(k).copied().unwrap_or(0));
            let [one, two] = [number[0], number[1]];
            let (value, most) = match kind {
                ComponentType::I8 => (f64::from(one as i8), 127.0),
                ComponentType::U8 => (f64::from(one), 255.0),
                ComponentType::I16 => (f64::from(i16::from_le_bytes([one, two])), 32767.0),
                ComponentType::U16 => (f64::from(u16::from_le_bytes([one, two])), 65535.0),
                ComponentType::U32 => (f64::from(u32::from_le_bytes(number)), 4_294_967_295.0),
                ComponentType::F32 => (f64::from(f32::from_le_bytes(number)), 1.0),
            };
            values.push(if normalized { f64::max(value / most, -1.0) } else { value });
        }
    }
    Some(values)
}
