//! Malformed images: PNG as texture and map; OpenEXR as environment, texture and map; Radiance HDR as environment.

use super::Case;
use super::makers::{Exr, chunk, deflate, hdr as made, png as built};

const BALL: &str = "[[object]]\nshape = 'sphere'\ndetail = 0\nmaterial = { preset = 'marble'";
const LAYER: &str = "layer = [{ sigma_s = 1, sigma_t = 2, g = 0 }]";
const READ: &str = "cannot be read; found ";

/// One case per file; the files take turns in these uses.
fn cases(name: &str, ways: &[&str], files: Vec<(Vec<u8>, &'static str)>) -> Vec<Case> {
    let text = |way: &str| match way {
        "map" => format!("{BALL}, layers = {{ maps = ['{name}'], scale = 1, {LAYER} }} }}\n"),
        "texture" => format!("{BALL}, texture = '{name}' }}\n"),
        _ => format!("{BALL} }}\n[[light]]\ntype = 'environment'\nimage = '{name}'\n"),
    };
    let line = "render a.toml -o b.png --size 4x4 --device cpu";
    let case = |(k, (bytes, words)): (usize, (Vec<u8>, &'static str))| {
        let text = text(ways[k % ways.len()]);
        Case::new(&[(name, &bytes), ("a.toml", text.as_bytes())], line, words)
    };
    files.into_iter().enumerate().map(case).collect()
}

/// A valid file with some bytes changed.
fn changed(mut bytes: Vec<u8>, at: usize, new: &[u8]) -> Vec<u8> {
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

pub fn png() -> Vec<Case> {
    let grey = [8, 0, 0, 0, 0];
    let good = built([2, 1], grey, &[0, 90, 90]);
    let cut = |length: usize| good[..length].to_vec();
    let parts = |chunks: &[Vec<u8>]| [&b"\x89PNG\r\n\x1a\n"[..], &chunks.concat()].concat();
    let head = chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 1, 8, 0, 0, 0, 0]);
    // Two pixels with a palette of this many bytes.
    let coloured = |length: usize| {
        let head = chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 1, 8, 3, 0, 0, 0]);
        let colours = chunk(b"PLTE", &vec![90; length]);
        parts(&[head, colours, chunk(b"IDAT", &deflate(&[0, 0, 0])), chunk(b"IEND", &[])])
    };
    let files = vec![
        (coloured(0), "a palette of 0 bytes"),
        (coloured(2), "a palette of 2 bytes, not of 1 to 256 colours of three bytes"),
        (coloured(4), "a palette of 4 bytes"),
        (coloured(771), "a palette of 771 bytes"),
        (Vec::new(), READ),
        (b"no picture".to_vec(), READ),
        (b"\xff\xd8\xff\xe0 a photograph".to_vec(), READ),
        (cut(8), READ),
        (cut(20), READ),
        (cut(33), READ),
        (cut(41), READ),
        (cut(good.len() - 13), READ),
        (changed(good.clone(), 0, &[0x88]), READ),
        (changed(good.clone(), 29, &[1, 2, 3, 4]), READ),
        (changed(good.clone(), 8, &[0xff, 0xff, 0xff, 0xff]), READ),
        (changed(good.clone(), 33, &[0x7f, 0xff, 0xff, 0xff]), READ),
        (changed(good.clone(), 43, &[7]), READ),
        (built([0, 1], grey, &[0]), READ),
        (built([1, 0], grey, &[]), READ),
        (built([u32::MAX, u32::MAX], grey, &[0]), READ),
        (built([1 << 16, 1 << 16], grey, &[0]), "65536 x 65536 pixels, more than "),
        (built([2048, 2047], [16, 6, 0, 0, 0], &[0]), "2048 x 2047 pixels in a file of "),
        (built([2048, 2048], [16, 6, 0, 0, 0], &[0]), "2048 x 2048 pixels in a file of "),
        (built([2, 1], [3, 0, 0, 0, 0], &[0, 90, 90]), READ),
        (built([2, 1], [8, 1, 0, 0, 0], &[0, 90, 90]), READ),
        (built([2, 1], [16, 3, 0, 0, 0], &[0, 90, 90]), READ),
        (built([2, 1], [8, 3, 0, 0, 0], &[0, 90, 90]), READ),
        (built([2, 1], [8, 0, 1, 0, 0], &[0, 90, 90]), READ),
        (built([2, 1], [8, 0, 0, 1, 0], &[0, 90, 90]), READ),
        (built([2, 1], [8, 0, 0, 0, 2], &[0, 90, 90]), READ),
        (built([2, 1], grey, &[9, 90, 90]), READ),
        (built([2, 1], grey, &[0, 90]), READ),
        (parts(&[chunk(b"IDAT", &deflate(&[0, 1, 1])), chunk(b"IEND", &[])]), READ),
        (parts(&[head.clone(), chunk(b"IEND", &[])]), READ),
        (parts(&[head.clone(), chunk(b"IDAT", &[0; 9]), chunk(b"IEND", &[])]), READ),
        (parts(&[head.clone(), chunk(b"ABCD", &[0; 9]), chunk(b"IEND", &[])]), READ),
        (parts(&[head, chunk(b"IDAT", &deflate(&[])), chunk(b"IEND", &[])]), READ),
        (built([2, 1], grey, &[0, 0, 0]), "the maps say that every layer lies at the surface"),
        (built([16_385, 1], grey, &[0; 16_386]), "too few or too many texels; found 16385 x 1"),
    ];
    // The last but one has to be a map, so its index must be odd; the last is added again as a texture.
    let mut all = cases("a.png", &["texture", "map"], files);
    assert!(all.len() % 2 == 1);
    all.swap_remove(all.len() - 1);
    all.extend(cases("a.png", &["texture"], vec![(built([16_385, 1], grey, &[0; 16_386]), "found 16385 x 1")]));
    all
}

/// A valid file with some fields changed.
fn edited(change: fn(&mut Exr)) -> Vec<u8> {
    let mut exr = Exr::default();
    change(&mut exr);
    exr.bytes()
}

pub fn exr() -> Vec<Case> {
    // The files take turns in the uses, in this order.
    let files = [cut_and_sized(), swollen_blocks(), wrong_fields()].concat();
    let mut all = cases("a.exr", &["sky", "texture", "map"], files);
    let bad = |value: f32| Exr { data: value.to_le_bytes().repeat(6), ..Exr::default() }.bytes();
    all.extend(cases("a.exr", &["sky"], vec![(bad(f32::NEG_INFINITY), "is no radiance; found [-inf, -inf, -inf]")]));
    let nameless = edited(|exr| exr.channels.iter_mut().for_each(|channel| channel.0 += "x"));
    let words = "cannot be read; found channels Bx, Gx, Rx; R, G and B, or Y, are read";
    all.extend(cases("a.exr", &["sky", "texture"], vec![(nameless.clone(), words), (nameless, words)]));
    all.extend(cases("a.exr", &["texture"], vec![(bad(f32::NAN), "is no albedo; found [NaN, NaN, NaN]")]));
    all.extend(cases("a.exr", &["map"], vec![(bad(f32::INFINITY), "is no share of a depth; found [inf]")]));
    all
}

fn cut_and_sized() -> Vec<(Vec<u8>, &'static str)> {
    let bytes = Exr::default().bytes();
    let cut = |length: usize| bytes[..length].to_vec();
    vec![
        (Vec::new(), READ),
        (b"no picture".to_vec(), READ),
        (cut(4), READ),
        (cut(8), READ),
        (cut(60), READ),
        (cut(bytes.len() - 40), READ),
        (cut(bytes.len() - 30), READ),
        (cut(bytes.len() - 1), READ),
        (changed(bytes.clone(), 0, &[0]), READ),
        (changed(bytes.clone(), 4, &[9]), READ),
        (changed(bytes.clone(), 4, &[0xff; 4]), READ),
        (edited(|exr| exr.window = [0, 0, i32::MAX, i32::MAX]), READ),
        (edited(|exr| exr.window = [i32::MIN, i32::MIN, i32::MAX, i32::MAX]), READ),
        (edited(|exr| exr.window = [0, 0, -1, -1]), READ),
        (edited(|exr| exr.window = [0, 0, 99_999, 99_999]), "100000 x 100000 pixels, more than "),
        (edited(|exr| exr.window = [0, 0, 2047, 2047]), READ),
    ]
}

/// Files that claim far more than they hold.
fn swollen_blocks() -> Vec<(Vec<u8>, &'static str)> {
    // One scan line whose block claims to have two gigabytes.
    let long: fn(&mut Exr) = |exr| {
        (exr.window, exr.compression, exr.block) = ([0, 0, 99_999, 0], 9, (0, i32::MAX));
        exr.data = vec![0; 4096];
    };
    // A DWAA block that claims 2^62 DC coefficients.
    let swollen: fn(&mut Exr) = |exr| {
        (exr.window, exr.compression, exr.block) = ([0, 0, 7, 7], 8, (0, 96));
        let counters = [2, 0, 0, 0, 6, 0, 0, 0, 0, 1u64 << 62, 0];
        exr.data = [&counters.map(u64::to_le_bytes).concat()[..], &[2, 0, 0x78, 0x9c, 0, 0, 0, 0]].concat();
    };
    // A tile of level 64.
    let high: fn(&mut Exr) = |exr| {
        (exr.flags, exr.tiles, exr.block) = (0x202, Some([2, 1]), (0, 0));
        exr.data = [&[64, 0, 24].map(i32::to_le_bytes).concat()[..], &[0; 24]].concat();
    };
    // Two scan lines whose offsets both point at the first block.
    let twice = {
        let bytes = edited(|exr| exr.window = [0, 0, 1, 1]);
        let (head, block) = bytes.split_at(bytes.len() - 32);
        let at = (bytes.len() as u64 - 32 + 8).to_le_bytes();
        [&head[..head.len() - 8], &at, &at, block].concat()
    };
    let crowd: fn(&mut Exr) = |exr| {
        exr.window = [0, 0, 2047, 2047];
        exr.channels = (0..999).map(|k| (format!("c{k}"), 2, [1, 1])).collect();
    };
    vec![
        (edited(crowd), "2048 x 2048 pixels in a file of "),
        (edited(long), "a block that ends beyond the file"),
        (edited(swollen), "a block of 8 x 8 pixels with a section of 4611686018427387904 bytes or numbers"),
        (edited(high), "a block of a level beyond the last"),
        (twice, "a block that is there twice"),
    ]
}

fn wrong_fields() -> Vec<(Vec<u8>, &'static str)> {
    // Shorter than the pixels themselves, or the block would not count as compressed.
    fn pack(exr: &mut Exr, compression: u8) {
        (exr.compression, exr.block, exr.data) = (compression, (0, 20), vec![0xa5; 20]);
    }
    vec![
        (edited(|exr| pack(exr, 1)), READ),
        (edited(|exr| pack(exr, 3)), READ),
        (edited(|exr| pack(exr, 4)), READ),
        (edited(|exr| pack(exr, 5)), READ),
        (edited(|exr| pack(exr, 6)), READ),
        (edited(|exr| pack(exr, 8)), READ),
        (edited(|exr| exr.compression = 99), READ),
        (edited(|exr| exr.channels.clear()), READ),
        (edited(|exr| exr.channels[0].1 = 7), READ),
        (edited(|exr| exr.channels[0].2 = [0, 0]), READ),
        (edited(|exr| exr.channels[0].2 = [-1, i32::MIN]), READ),
        (edited(|exr| exr.block = (77, 24)), READ),
        (edited(|exr| exr.block = (i32::MIN, 24)), READ),
        (edited(|exr| exr.block = (0, i32::MAX)), READ),
        (edited(|exr| exr.block = (0, -1)), READ),
        (edited(|exr| exr.block = (0, 8)), READ),
        (edited(|exr| (exr.flags, exr.tiles) = (0x202, Some([0, 0]))), READ),
        (edited(|exr| (exr.flags, exr.tiles) = (0x202, Some([u32::MAX, u32::MAX]))), READ),
        (
            edited(|exr| (exr.flags, exr.tiles) = (0x202, Some([1 << 19, 373]))),
            "found tiles of 524288 x 373 pixels, more than ",
        ),
        (edited(|exr| exr.flags = 0x1002), READ),
        (edited(|exr| exr.flags = 0x802), "cannot be read; found deep data"),
        (edited(|exr| exr.flags = 0x802), "cannot be read; found deep data"),
        (edited(|exr| exr.flags = 0x802), "cannot be read; found deep data"),
    ]
}

pub fn hdr() -> Vec<Case> {
    const HEAD: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
    let of = |rest: &str, pixels: &[u8]| made(&format!("{HEAD}{rest}\n"), pixels);
    let read = "light.0.image: a.hdr: the image cannot be read; found ";
    let row = |bytes: &[u8]| of("-Y 1 +X 8", &[&[2, 2, 0, 8], bytes].concat());
    let files = vec![
        (Vec::new(), read),
        (b"no picture".to_vec(), read),
        (b"#?RADIANCE".to_vec(), read),
        (b"#?RADIANCE\n\n".to_vec(), read),
        (HEAD.into(), read),
        (made("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", &[1; 4]), read),
        (made("#?RADIANCE\nFORMAT=\n\n-Y 1 +X 1\n", &[1; 4]), read),
        (made("#?RADIANCE\nEXPOSURE=x\nFORMAT=32-bit_rle_rgbe\n\n-Y 9 +X 1\n", &[1; 4]), read),
        (of("", &[]), read),
        (of("-Y 1", &[1; 4]), read),
        (of("-Y 1 +X", &[1; 4]), read),
        (of("-Y a +X b", &[1; 4]), read),
        (of("+Y 1 +X 1", &[1; 4]), read),
        (of("+X 1 -Y 1", &[1; 4]), read),
        (of("-Y 1 +X 1 +Z 1", &[1; 4]), read),
        (of("-Y -1 +X 1", &[1; 4]), read),
        (of("-Y 0 +X 1", &[]), "a.hdr: the image "),
        (of("-Y 1 +X 0", &[]), "a.hdr: the image "),
        (of("-Y 99999999999 +X 1", &[1; 4]), read),
        (of("-Y 4294967295 +X 4294967295", &[1; 4]), read),
        (of("-Y 100000 +X 100000", &[1; 4]), "100000 x 100000 pixels, more than 8388608"),
        (of("-Y 8388608 +X 1", &[1; 4]), read),
        (of("-Y 1 +X 8388608", &[1; 4]), read),
        (of("-Y 1 +X 2", &[1; 7]), read),
        (of("-Y 2 +X 2", &[1; 9]), read),
        (row(&[]), read),
        (row(&[0x88, 1]), read),
        (row(&[0xff, 1, 0xff, 1, 0xff, 1, 0xff, 1]), read),
        (row(&[0, 0, 0, 0]), read),
        (row(&[9, 1, 1, 1, 1, 1, 1, 1, 1, 1]), read),
        (of("-Y 1 +X 9", &[2, 2, 0, 8, 0x88, 1, 0x88, 1, 0x88, 1, 0x88, 1]), read),
        (of("-Y 1 +X 3", &[1, 1, 1, 255, 1, 1, 1, 255]), read),
        (made(&"#?RADIANCE\n".repeat(9), &[]), read),
        (made(&format!("#?RADIANCE\n{}", "x".repeat(100_000)), &[]), read),
    ];
    cases("a.hdr", &["sky"], files)
}
