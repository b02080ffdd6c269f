//! Elements of a PLY file.

use super::colors::{linear, share};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// An element `vertex`.
#[derive(Debug, Clone, Default)]
pub(super) struct Vertex {
    /// Its position.
    pub position: [f64; 3],
    /// Its normal, of any length; 0 if it has none.
    pub normal: [f64; 3],
    /// Its texture coordinates.
    pub uv: [f64; 2],
    /// Its colour, r g b, linear, 0 to 1.
    pub color: [f32; 3],
}

/// An element `face`.
#[derive(Debug, Clone, Default)]
pub(super) struct Face {
    /// Its corners, as numbers of vertices; `u32::MAX` for a number that no vertex can have.
    pub corners: Vec<u32>,
    /// Texture coordinates of its corners, two numbers each; empty if it has none.
    pub uvs: Vec<f64>,
}

/// Any other element; nothing of it is kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Self
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" | "ny" | "nz" => {
                // Made anew where it is none, so that it cannot refuse a file.
                let axis = ["nx", "ny"].iter().position(|other| *other == name).unwrap_or(2);
                self.normal[axis] = number(&property).unwrap_or_default();
                return PropertyAccessResult::Ignored;
            }
            "u" | "s" | "texture_u" => &mut self.uv[0],
            "v" | "t" | "texture_v" => &mut self.uv[1],
            "red" | "green" | "blue" => {
                let Some(color) = color(&property) else { return PropertyAccessResult::UnsupportedType };
                self.color[["red", "green"].iter().position(|other| *other == name).unwrap_or(2)] = color;
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(number) = number(&property) else { return PropertyAccessResult::UnsupportedType };
        *place = number;
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => match corners(property) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            "texcoord" => match property {
                Property::ListFloat(list) => self.uvs = list.into_iter().map(f64::from).collect(),
                Property::ListDouble(list) => self.uvs = list,
                _ => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A single number; none for a list.
fn number(property: &Property) -> Option<f64> {
    Some(match property {
        Property::Char(x) => (*x).into(),
        Property::UChar(x) => (*x).into(),
        Property::Short(x) => (*x).into(),
        Property::UShort(x) => (*x).into(),
        Property::Int(x) => (*x).into(),
        Property::UInt(x) => (*x).into(),
        Property::Float(x) => (*x).into(),
        Property::Double(x) => *x,
        _ => return None,
    })
}

/// Linear light of a colour: unsigned numbers of 8 and 16 bits are sRGB, floats linear; none for other types.
fn color(property: &Property) -> Option<f32> {
    Some(match property {
        Property::UChar(x) => linear(f64::from(*x) / 255.0),
        Property::UShort(x) => linear(f64::from(*x) / 65535.0),
        Property::Float(x) => share(f64::from(*x)),
        Property::Double(x) => share(*x),
        _ => return None,
    })
}

/// Numbers of vertices; none unless these are lists of whole numbers.
fn corners(property: Property) -> Option<Vec<u32>> {
    fn list<T>(list: Vec<T>) -> Vec<u32>
    where
        u32: TryFrom<T>,
    {
        list.into_iter().map(|x| u32::try_from(x).unwrap_or(u32::MAX)).collect()
    }
    Some(match property {
        Property::ListChar(x) => list(x),
        Property::ListUChar(x) => list(x),
        Property::ListShort(x) => list(x),
        Property::ListUShort(x) => list(x),
        Property::ListInt(x) => list(x),
        Property::ListUInt(x) => list(x),
        _ => return None,
    })
}
