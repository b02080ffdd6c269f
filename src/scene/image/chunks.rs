//! Checks the chunks of an OpenEXR file before its reader sees them: the reader trusts what they state about the pixels
//! they hold and the memory they take.

use std::collections::HashSet;

use exr::block::chunk::TileCoordinates;
use exr::compression::Compression;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::Vec2;

use crate::scene::files::Files;

/// Memory that the reader and this check take per chunk, bytes.
const BYTES: u64 = 96;
/// Memory per packed byte: of run-length data, which is held twice, and of deflated data.
const MOST_RUN: u64 = 128;
const MOST_DEFLATED: u64 = 1032;

/// The error for a chunk that ends too early.
const CUT: &str = "a block that ends beyond the file";

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], String> {
    let (head, tail) = rest.split_first_chunk().ok_or(CUT)?;
    *rest = tail;
    Ok(*head)
}

fn number(rest: &mut &[u8]) -> Result<i32, String> {
    take(rest).map(i32::from_le_bytes)
}

/// Checks that each part has each of its blocks once, within the file, and of a size that may be unpacked. The tables
/// of their offsets begin at `start`.
pub(super) fn check(files: &Files, bytes: &[u8], start: usize, meta: &MetaData) -> Result<(), String> {
    let mut start = start;
    for (part, header) in meta.headers.iter().enumerate() {
        files.need(header.chunk_count as u64 * BYTES).map_err(|error| error.to_string())?;
        let end = header.chunk_count.checked_mul(8).and_then(|length| start.checked_add(length));
        let table = end.and_then(|end| bytes.get(start..end)).ok_or("a list of blocks that ends beyond the file")?;
        let mut seen = HashSet::new();
        for at in table.as_chunks().0 {
            let at = usize::try_from(u64::from_le_bytes(*at)).ok();
            let mut rest = at.and_then(|at| bytes.get(at..)).ok_or("a block that begins beyond the file")?;
            if meta.requirements.has_multiple_layers && number(&mut rest)? != part as i32 {
                return Err("a block of another part of the file".into());
            }
            let place = place(header, &mut rest)?;
            if !seen.insert(place) {
                return Err(format!("a block that is there twice, {place:?}"));
            }
            let length = usize::try_from(number(&mut rest)?).map_err(|_| "a block of negative length")?;
            packed(files, header, place, rest.get(..length).ok_or(CUT)?)?;
        }
        start = end.unwrap_or(start);
    }
    Ok(())
}

/// The block of a part that a chunk claims to hold.
fn place(header: &Header, rest: &mut &[u8]) -> Result<TileCoordinates, String> {
    let index = |at: i32| usize::try_from(at).map_err(|_| "a block before the first".to_string());
    if let BlockDescription::Tiles(_) = header.blocks {
        let [x, y, level_x, level_y] = [number(rest)?, number(rest)?, number(rest)?, number(rest)?];
        // Sides halve at each level, so that there are at most 32.
        if level_x.max(level_y) > 31 {
            return Err("a block of a level beyond the last".into());
        }
        let [tile_index, level_index] = [Vec2(index(x)?, index(y)?), Vec2(index(level_x)?, index(level_y)?)];
        return Ok(TileCoordinates { tile_index, level_index });
    }
    let line = i64::from(number(rest)?) - i64::from(header.own_attributes.layer_position.y());
    let lines = header.compression.scan_lines_per_block();
    let line = usize::try_from(line).ok().filter(|line| line.is_multiple_of(lines));
    let line = line.ok_or("a block that begins where none does")?;
    Ok(TileCoordinates { tile_index: Vec2(0, line / lines), level_index: Vec2(0, 0) })
}

/// Checks that unpacking a block fits the memory.
fn packed(files: &Files, header: &Header, place: TileCoordinates, data: &[u8]) -> Result<(), String> {
    let bounds = header.get_absolute_block_pixel_coordinates(place).map_err(|error| error.to_string())?;
    let (width, height) = (bounds.size.width() as u64, bounds.size.height() as u64);
    let pixel = header.channels.bytes_per_pixel as u64;
    if data.len() as u64 >= width * height * pixel {
        // Not compressed.
        return Ok(());
    }
    let most = match header.compression {
        Compression::RLE => MOST_RUN,
        Compression::DWAA(_) | Compression::DWAB(_) => {
            // A DWA block begins with eleven 64-bit counters: version, sizes before and after packing, and kind. It
            // transforms squares of 8 x 8 pixels.
            let squares = width.next_multiple_of(8) * height.next_multiple_of(8) * pixel;
            let sizes = data.as_chunks().0.iter().take(10).skip(1).map(|size| u64::from_le_bytes(*size));
            if let Some(size) = sizes.max().filter(|size| *size > 4 * squares + 4096) {
                return Err(format!("a block of {width} x {height} pixels with a section of {size} bytes or numbers"));
            }
            MOST_DEFLATED
        }
        _ => return Ok(()),
    };
    files.need(data.len() as u64 * most).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::*;
    use std::io::Cursor;

    /// A file with layers of these sizes, and the start of its offset tables.
    fn file(sizes: &[(usize, usize)], compression: Compression) -> (Vec<u8>, usize) {
        let layer = |(k, size): (usize, &(usize, usize))| {
            let attributes = LayerAttributes::named(Text::new_or_panic(format!("layer {k}")));
            let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
            let channels = SpecificChannels::rgb(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 1.0f32));
            Layer::new(*size, attributes, encoding, channels)
        };
        let layers: Vec<_> = sizes.iter().enumerate().map(layer).collect();
        let mut bytes = Cursor::new(Vec::new());
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((64, 64)));
        Image::from_layers(attributes, layers).write().to_buffered(&mut bytes).expect("it is written");
        let bytes = bytes.into_inner();
        let start = start(&bytes);
        (bytes, start)
    }

    fn meta(bytes: &[u8]) -> (MetaData, usize) {
        let mut cursor = Cursor::new(bytes);
        let meta = MetaData::read_from_buffered(&mut cursor, false).expect("headers");
        (meta, cursor.position() as usize)
    }

    fn start(bytes: &[u8]) -> usize {
        meta(bytes).1
    }

    fn checked(bytes: &[u8]) -> std::result::Result<(), String> {
        let (meta, start) = meta(bytes);
        check(&Files::default(), bytes, start, &meta)
    }

    #[test]
    fn good_files_pass() {
        let all =
            [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ];
        for compression in all.into_iter().chain([Compression::PXR24, Compression::B44, Compression::DWAA(None)]) {
            for sizes in [&[(50, 40)][..], &[(1, 1), (16, 16)]] {
                assert_eq!(checked(&file(sizes, compression).0), Ok(()), "{compression:?}, {sizes:?}");
            }
        }
    }

    #[test]
    fn a_block_in_another_ones_place_is_told() {
        // The first layer's only offset points to the second layer's block.
        let (mut bytes, start) = file(&[(1, 1), (16, 16)], Compression::Uncompressed);
        let theirs = bytes[start + 8..start + 16].to_vec();
        bytes[start..start + 8].copy_from_slice(&theirs);
        assert_eq!(checked(&bytes), Err("a block of another part of the file".into()));
        // The second offset repeats the first.
        let (mut bytes, start) = file(&[(4, 4)], Compression::Uncompressed);
        let first = bytes[start..start + 8].to_vec();
        bytes[start + 8..start + 16].copy_from_slice(&first);
        assert!(checked(&bytes).is_err_and(|words| words.starts_with("a block that is there twice")));
        bytes[start..start + 8].fill(0xff);
        assert_eq!(checked(&bytes), Err("a block that begins beyond the file".into()));
    }

    #[test]
    fn a_block_may_not_unpack_to_more_than_there_is_memory() {
        let (mut bytes, start) = file(&[(64, 64)], Compression::DWAA(None));
        let at = u64::from_le_bytes(*bytes[start..].first_chunk().expect("an entry")) as usize;
        // The counters follow line and length; the second is a size.
        bytes[at + 16..at + 24].copy_from_slice(&(1u64 << 40).to_le_bytes());
        assert!(checked(&bytes).is_err_and(|words| words.contains("64 x 32 pixels with a section of 1099511627776")));
        let (bytes, start) = file(&[(64, 64)], Compression::RLE);
        let tight = Files::held([], 1024);
        assert!(check(&tight, &bytes, start, &meta(&bytes).0).is_err_and(|words| words.contains("--limit-memory")));
    }
}
