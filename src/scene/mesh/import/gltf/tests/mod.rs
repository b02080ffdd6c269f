//! Small files, built here.

mod faults;
mod lenient;
mod looks;
mod shapes;

use super::*;

/// Bytes of a buffer, and the accessors into it.
#[derive(Default)]
pub(super) struct Builder {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Builder {
    fn add(&mut self, bytes: &[u8], kind: u32, count: usize, of: &str, more: &str) -> usize {
        let view = self.view(bytes);
        let accessor = format!(r#"{{"bufferView":{view},"componentType":{kind},"count":{count},"type":"{of}"{more}}}"#);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds a buffer view of these bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{}}}"#, bytes.len()));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// Adds an accessor of floats with `N` in an element.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let of = ["", "SCALAR", "VEC2", "VEC3", "VEC4"].get(N).unwrap_or(&"MAT4");
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, 5126, values.len(), of, "")
    }

    /// Adds an accessor of 16-bit numbers with `N` in an element; `more` are further keys.
    pub fn shorts<const N: usize>(&mut self, values: &[[u16; N]], more: &str) -> usize {
        let of = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.add(&bytes, 5123, values.len(), of, more)
    }

    /// The file with these further keys at the top, as GLB.
    pub fn glb(&self, rest: &str) -> Vec<u8> {
        let mut text = format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.bytes.len(),
            self.views.join(","),
            self.accessors.join(",")
        );
        while !text.len().is_multiple_of(4) {
            text.push(' ');
        }
        let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
        let chunks = [chunk(b"JSON", text.as_bytes()), chunk(b"BIN\0", &self.bytes)].concat();
        [&b"glTF\x02\0\0\0"[..], &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat()
    }
}

pub(super) const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

/// Reads the mesh of such a file.
pub(super) fn soup(bytes: &[u8], part: Option<u32>, wanted: Option<bool>) -> Result<Soup, String> {
    let wanted = wanted.map(|own| Coordinates { key: "texture", own });
    let read = read(&Files::default(), Path::new("a.glb"), bytes, part, (wanted, true));
    read.map_err(|fault| fault.to_string())
}
