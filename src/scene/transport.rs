//! How light is carried through the material: which tree, which sources, and how fine the links are.

use super::file::TransportFile;
use super::range::{self, Checked};
use serde::Deserialize;

/// How much an emitter's solid angle may vary over a receiver's children, in steradian.
pub const RECEIVER_ANGLE: f64 = 0.05;
/// The largest solid angle of a cluster that emits over a link, in steradian.
pub const EMITTER_ANGLE: f64 = 0.07;
/// The smallest ratio of projected to true area of an emitter that may be linked.
pub const PLANARITY: f64 = 0.3;
/// The relative error allowed in one form factor.
pub const FORM_FACTOR_TOLERANCE: f64 = 1e-2;

/// How faces are grouped into clusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hierarchy {
    /// Neighbouring clusters are joined, pair by pair, the most compact first.
    #[default]
    FaceClusters,
    /// The box is split at the median centre of its longest axis.
    Median,
}

/// From where to where the dipole's distances are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Between the points on the surface.
    #[default]
    Radial,
    /// To sources displaced along the emitter's normal, as the paper's table 1 has it.
    Table1,
}

/// The settings of light transport, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transport {
    /// How faces are grouped.
    pub hierarchy: Hierarchy,
    /// How distances are measured.
    pub distance: Distance,
    /// epsilon_1: how much an emitter's solid angle may vary over a receiver's children, steradian, above 0.
    pub receiver_angle: f64,
    /// epsilon_2: largest solid angle of a cluster that emits over a link, steradian, above 0.
    pub emitter_angle: f64,
    /// Smallest A'/A (projected to true area) of an emitter that may be linked, 0 to 1.
    pub planarity: f64,
    /// Relative error allowed in one form factor, 1e-4 to 1e-1.
    pub form_factor_tolerance: f64,
}

impl Transport {
    /// Checks `[transport]`.
    pub(super) fn check(file: &TransportFile) -> Checked<Self> {
        let angle = |key, value| range::number(key, value, |x| x > 0.0, "steradian, above 0");
        Ok(Self {
            hierarchy: file.hierarchy,
            distance: file.distance,
            receiver_angle: angle("transport.receiver_angle", file.receiver_angle)?,
            emitter_angle: angle("transport.emitter_angle", file.emitter_angle)?,
            planarity: range::number("transport.planarity", file.planarity, |x| (0.0..=1.0).contains(&x), "0 to 1")?,
            form_factor_tolerance: range::number(
                "transport.form_factor_tolerance",
                file.form_factor_tolerance,
                |x| (1e-4..=1e-1).contains(&x),
                "1e-4 to 1e-1",
            )?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transport(text: &str) -> Result<Transport, String> {
        let file: TransportFile = toml::from_str(text).map_err(|e| e.message().to_string())?;
        Transport::check(&file).map_err(|e| e.to_string())
    }

    #[test]
    fn everything_has_a_default() {
        let transport = transport("distance = 'table1'").expect("defaults");
        assert_eq!(transport.hierarchy, Hierarchy::FaceClusters);
        assert_eq!(transport.distance, Distance::Table1);
        assert_eq!((transport.receiver_angle, transport.planarity), (RECEIVER_ANGLE, PLANARITY));
    }

    #[test]
    fn names_the_key_at_fault() {
        let cases = [
            ("receiver_angle = 0", "transport.receiver_angle: out of range; found 0; expected ster"),
            ("emitter_angle = inf", "transport.emitter_angle: not a finite number; found inf"),
            ("planarity = 1.1", "transport.planarity: out of range; found 1.1; expected 0 to 1"),
            ("form_factor_tolerance = 0.5", "transport.form_factor_tolerance: out of range"),
            ("hierarchy = 'octree'", "unknown variant `octree`, expected `face-clusters` or `median`"),
        ];
        for (text, message) in cases {
            let error = transport(text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
