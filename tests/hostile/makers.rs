//! Small images assembled byte by byte, so that any of their bytes can be wrong.

/// A zlib stream of one stored block.
pub fn deflate(bytes: &[u8]) -> Vec<u8> {
    let length = bytes.len() as u16;
    let (mut a, mut b) = (1u32, 0u32);
    for &byte in bytes {
        a = (a + u32::from(byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    let head = [&[0x78, 1, 1][..], &length.to_le_bytes(), &(!length).to_le_bytes()].concat();
    [&head, bytes, &(b << 16 | a).to_be_bytes()].concat()
}

/// A chunk of a PNG.
pub fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [name, data].concat();
    let mut crc = u32::MAX;
    for &byte in &body {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
        }
    }
    [&(data.len() as u32).to_be_bytes()[..], &body, &(!crc).to_be_bytes()].concat()
}

/// A PNG with this header and these filtered rows.
pub fn png(size: [u32; 2], rest: [u8; 5], rows: &[u8]) -> Vec<u8> {
    let head = [&size[0].to_be_bytes()[..], &size[1].to_be_bytes(), &rest].concat();
    let parts = [chunk(b"IHDR", &head), chunk(b"IDAT", &deflate(rows)), chunk(b"IEND", &[])];
    [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
}

/// The fields of an OpenEXR file.
#[derive(Clone)]
pub struct Exr {
    pub window: [i32; 4],
    pub compression: u8,
    /// Name, kind (0 whole, 1 half, 2 float) and sampling.
    pub channels: Vec<(String, i32, [i32; 2])>,
    pub flags: u32,
    pub tiles: Option<[u32; 2]>,
    /// The line and the length that its only block claims.
    pub block: (i32, i32),
    pub data: Vec<u8>,
}

impl Default for Exr {
    /// Two pixels of float red, green and blue.
    fn default() -> Self {
        let channels = ["B", "G", "R"].map(|name| (name.to_string(), 2, [1, 1])).to_vec();
        let data = [0.5f32; 6].iter().flat_map(|x| x.to_le_bytes()).collect();
        Self { window: [0, 0, 1, 0], compression: 0, channels, flags: 2, tiles: None, block: (0, 24), data }
    }
}

impl Exr {
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = [20_000_630u32.to_le_bytes(), self.flags.to_le_bytes()].concat();
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            let length = (value.len() as u32).to_le_bytes();
            out.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat());
        };
        let mut list = Vec::new();
        for (name, kind, sampling) in &self.channels {
            let numbers = [*kind, 0, sampling[0], sampling[1]].map(i32::to_le_bytes).concat();
            list.extend([name.as_bytes(), b"\0", &numbers].concat());
        }
        list.push(0);
        let window = self.window.map(i32::to_le_bytes).concat();
        attribute("channels", "chlist", &list);
        attribute("compression", "compression", &[self.compression]);
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        if let Some([x, y]) = self.tiles {
            attribute("tiles", "tiledesc", &[&x.to_le_bytes()[..], &y.to_le_bytes(), &[0]].concat());
        }
        out.push(0);
        let (line, length) = self.block;
        out.extend((out.len() as u64 + 8).to_le_bytes());
        out.extend([&line.to_le_bytes()[..], &length.to_le_bytes(), &self.data].concat());
        out
    }
}

/// A Radiance file with this header and these pixels.
pub fn hdr(head: &str, pixels: &[u8]) -> Vec<u8> {
    [head.as_bytes(), pixels].concat()
}
