//! Settings of light transport: hierarchy, scheme and accuracy.

pub use super::choices::{ClusterForm, Distance, Hierarchy, Near, Oracle, Receivers, Scheme};
use super::local::{BLUR_TEXTURE, CDRF_TABLE, Cdrf, Kappa};
use super::range::{self, Checked};
use crate::error::Input;
use crate::layout::MOST_STEPS;
use serde::{Deserialize, Deserializer};
use std::ops::RangeInclusive;
use toml::{Table, Value};

/// Most photons of a channel.
pub const MOST_WALKS: u32 = 1_000_000_000;

/// The settings of light transport, as in `[transport]`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Transport {
    /// How light is transported from clusters to receivers.
    pub scheme: Scheme,
    /// The reason for that scheme, printed with the plan.
    #[serde(skip)]
    pub because: &'static str,
    /// The criterion for treating a cluster as one emitter, if given: each scheme has its own.
    pub oracle: Option<Oracle>,
    /// Scheme blocks: target relative error of the radiosity (L2, worst channel), 1e-6 to 0.5.
    pub tolerance: f64,
    /// Scheme blocks: order of the emitters' moments, 0 to 2.
    pub order: u32,
    /// How faces are grouped into clusters.
    pub hierarchy: Hierarchy,
    /// Hierarchies butterfly and shrink-wrap: levels of 4-to-1 subdivision of the base, 1 to 8, if given.
    #[serde(deserialize_with = "count")]
    pub levels: Option<u32>,
    /// Where radiosity is computed for a picture.
    pub receivers: Receivers,
    /// Maximum levels of 4-to-1 subdivision where irradiance varies over a triangle, 0 to 4.
    pub subdivide: u32,
    /// Whether triangles stay as they are, however long: since `receivers = "faces"` was given, or they were divided
    /// already.
    #[serde(skip)]
    pub divided: bool,
    /// How distances are measured.
    pub distance: Distance,
    /// How form factors of near triangles are evaluated.
    pub near: Near,
    /// Scheme links: how form factors of near clusters are evaluated, if given; see [`Self::projects`].
    pub cluster: Option<ClusterForm>,
    /// epsilon_1: how much an emitter's solid angle may vary over a receiver's children, steradian, above 0.
    pub receiver_angle: f64,
    /// epsilon_2: largest solid angle of a cluster that emits over a link, steradian, above 0.
    pub emitter_angle: f64,
    /// Smallest A'/A (projected to true area) of an emitter that may be linked, 0 to 1.
    pub planarity: f64,
    /// Relative error allowed in one form factor, 1e-4 to 1e-1.
    pub form_factor_tolerance: f64,
    /// The irradiance octree: solid angle from which a cell is opened, steradian, above 0.
    pub octree_angle: f64,
    /// The random walk: estimated relative error of means over patches (L2, worst channel), 1e-4 to 1.
    pub walk_error: f64,
    /// The random walk: photons of each channel and object instead of that error, at least 1, if given.
    #[serde(deserialize_with = "count")]
    pub walks: Option<u32>,
    /// Diffusion: steps of the solver instead of `tolerance`, 1 to 30, if given.
    #[serde(deserialize_with = "count")]
    pub steps: Option<u32>,
    /// Mode incremental: maximum number of form factors that a frame computes for links that are kept, at least 1;
    /// unlimited if omitted.
    #[serde(deserialize_with = "count")]
    pub budget: Option<u32>,
    /// How the CDRF is evaluated.
    pub cdrf: Cdrf,
    /// Rows and columns of the CDRF table, 8 to 1024.
    pub cdrf_table: u32,
    /// Which curvature the CDRF takes.
    pub curvature: Kappa,
    /// Whether translucent objects keep their texture coordinates although no texture needs them.
    pub unwrap: bool,
    /// Transport texture-blur: side of the texture, 16 to 2048 texels.
    pub blur_texture: u32,
}

impl Transport {
    /// Whether near clusters are integrated over their projection: in scheme links with exact form factors, unless
    /// `cluster` selects one sample.
    #[must_use]
    pub fn projects(&self) -> bool {
        let exact = self.scheme == Scheme::Links && self.near == Near::Exact;
        exact && self.cluster != Some(ClusterForm::Sample)
    }

    /// Checks `[transport]`, in which these keys are given, and chooses scheme and hierarchy where they are not.
    pub(super) fn check(&self, given: &Table) -> Checked<Self> {
        let has = |key: &str| given.contains_key(key);
        for (key, value, range, expected) in self.numbers() {
            let written = given.get(key).and_then(Value::as_integer).map(|number| number as f64);
            if let Some(value) = written.or(value) {
                range::number(&format!("transport.{key}"), value, |x| range.contains(&x), expected)?;
            }
        }
        let (scheme, because) = self.chosen_scheme(&has)?;
        let fault = |key: &str, what: &str| Input::new(what).key(format!("transport.{key}"));
        if scheme == Scheme::Links && self.receivers == Receivers::Pixels {
            let fault = fault("receivers", "scheme links has no receivers at pixels").found("pixels");
            return Err(fault.expected("faces or auto, or scheme = \"blocks\""));
        }
        if self.near == Near::PointSampling && self.cluster == Some(ClusterForm::Projected) {
            let fault =
                fault("cluster", "point samples are of triangles; a cluster takes one sample").found("projected");
            return Err(fault.expected("sample, or transport.near = \"exact\""));
        }
        if has("levels") && !matches!(self.hierarchy, Hierarchy::Butterfly | Hierarchy::ShrinkWrap) {
            let fault = fault("levels", "only a hierarchy of 4-to-1 splits has levels");
            return Err(fault.expected("hierarchy = \"butterfly\" or \"shrink-wrap\""));
        }
        let hierarchy = match scheme {
            _ if has("hierarchy") => self.hierarchy,
            Scheme::Blocks => Hierarchy::Median,
            Scheme::Links => Hierarchy::FaceClusters,
        };
        Ok(Self { scheme, because, hierarchy, ..*self })
    }

    /// The keys that are numbers: their values, if given, and their ranges, which are also put into words.
    fn numbers(&self) -> [(&'static str, Option<f64>, RangeInclusive<f64>, &'static str); 15] {
        let (angle, steradian) = (f64::MIN_POSITIVE..=f64::MAX, "steradian, above 0");
        let whole = |number: Option<u32>| number.map(f64::from);
        [
            ("tolerance", Some(self.tolerance), 1e-6..=0.5, "1e-6 to 0.5"),
            ("order", whole(Some(self.order)), 0.0..=2.0, "0, 1 or 2"),
            ("levels", whole(self.levels), 1.0..=8.0, "1 to 8"),
            ("subdivide", whole(Some(self.subdivide)), 0.0..=4.0, "0 to 4"),
            ("receiver_angle", Some(self.receiver_angle), angle.clone(), steradian),
            ("emitter_angle", Some(self.emitter_angle), angle.clone(), steradian),
            ("planarity", Some(self.planarity), 0.0..=1.0, "0 to 1"),
            ("form_factor_tolerance", Some(self.form_factor_tolerance), 1e-4..=1e-1, "1e-4 to 1e-1"),
            ("octree_angle", Some(self.octree_angle), angle, steradian),
            ("walk_error", Some(self.walk_error), 1e-4..=1.0, "1e-4 to 1"),
            ("walks", whole(self.walks), 1.0..=f64::from(MOST_WALKS), "photons of a channel, 1 to 1000000000"),
            ("steps", whole(self.steps), 1.0..=MOST_STEPS as f64, "steps of the solver, 1 to 30"),
            ("budget", whole(self.budget), 1.0..=f64::MAX, "form factors of a frame, 1 to 4294967295"),
            ("cdrf_table", whole(Some(self.cdrf_table)), 8.0..=1024.0, "8 to 1024"),
            ("blur_texture", whole(Some(self.blur_texture)), 16.0..=2048.0, "16 to 2048"),
        ]
    }

    /// The scheme that the keys ask for, and the reason; contradicting keys are an error.
    fn chosen_scheme(&self, has: &dyn Fn(&str) -> bool) -> Checked<(Scheme, &'static str)> {
        let angles = ["receiver_angle", "emitter_angle", "planarity"].into_iter().any(has);
        let of_oracle = if self.oracle == Some(Oracle::SolidAngle) { Scheme::Links } else { Scheme::Blocks };
        let reasons = [
            (has("scheme"), self.scheme, "transport.scheme says so"),
            (self.oracle.is_some(), of_oracle, "transport.oracle belongs to it"),
            (angles, Scheme::Links, "receiver_angle, emitter_angle or planarity is given"),
            (
                self.distance == Distance::Table1,
                Scheme::Links,
                "moments work with radial distances only, transport.distance is table1",
            ),
            (self.cluster.is_some(), Scheme::Links, "transport.cluster belongs to it"),
            (
                self.near == Near::PointSampling,
                Scheme::Links,
                "transport.near is point-sampling, to compare the paper's own method with",
            ),
        ];
        let mut reasons = reasons.into_iter().filter(|(holds, ..)| *holds);
        let Some((_, chosen, because)) = reasons.next() else {
            return Ok((Scheme::Blocks, "it meets transport.tolerance with the least work"));
        };
        match reasons.find(|(_, scheme, _)| *scheme != chosen) {
            Some((.., other)) => Err(Input::new("keys of [transport] contradict each other")
                .found(format!("{because} for one scheme, {other} for the other"))
                .expected(
                    "keys of one scheme: blocks (tolerance, order) or links (receiver_angle, emitter_angle, planarity)",
                )),
            None => Ok((chosen, because)),
        }
    }
}

/// A count that is written: one that no `u32` holds becomes the nearest, since [`Transport::check`] tells its range.
fn count<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let number = i64::deserialize(from)?;
    Ok(Some(number.clamp(0, u32::MAX.into()) as u32))
}

impl Default for Transport {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            because: "",
            oracle: None,
            tolerance: 1e-3,
            order: 2,
            hierarchy: Hierarchy::default(),
            levels: None,
            receivers: Receivers::default(),
            subdivide: 0,
            divided: false,
            distance: Distance::default(),
            near: Near::default(),
            cluster: None,
            receiver_angle: 0.05,
            emitter_angle: 0.07,
            planarity: 0.3,
            form_factor_tolerance: 1e-2,
            octree_angle: 0.2,
            walk_error: 0.02,
            walks: None,
            steps: None,
            budget: None,
            cdrf: Cdrf::default(),
            cdrf_table: CDRF_TABLE,
            curvature: Kappa::default(),
            unwrap: false,
            blur_texture: BLUR_TEXTURE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transport(text: &str) -> Result<Transport, String> {
        let asked: Transport = toml::from_str(text).map_err(|e| e.message().to_string())?;
        asked.check(&text.parse().unwrap()).map_err(|e| e.to_string())
    }

    #[test]
    fn everything_has_a_default() {
        let transport = transport("distance = 'table1'").expect("defaults");
        assert_eq!((transport.hierarchy, transport.scheme), (Hierarchy::FaceClusters, Scheme::Links));
        assert_eq!((transport.distance, transport.near), (Distance::Table1, Near::Exact));
        assert_eq!((transport.receiver_angle, transport.planarity), (0.05, 0.3));
    }

    #[test]
    fn point_samples_belong_to_the_published_scheme() {
        let sampled = transport("near = 'point-sampling'").expect("a scheme");
        assert_eq!((sampled.scheme, sampled.near), (Scheme::Links, Near::PointSampling));
        let error = transport("near = 'point-sampling'\nscheme = 'blocks'").err().unwrap_or_default();
        assert!(error.contains("contradict") && error.contains("point-sampling"), "{error}");
    }

    #[test]
    fn clusters_are_projected_in_the_published_scheme() {
        let projects = |text: &str| transport(text).map(|transport| transport.projects());
        assert_eq!(projects(""), Ok(false));
        assert_eq!(projects("scheme = 'links'"), Ok(true));
        assert_eq!(projects("cluster = 'projected'"), Ok(true));
        assert_eq!(projects("cluster = 'sample'"), Ok(false));
        assert_eq!(projects("near = 'point-sampling'"), Ok(false));
        let error = projects("near = 'point-sampling'\ncluster = 'projected'").err().unwrap_or_default();
        assert!(error.starts_with("transport.cluster: point samples are of triangles"), "{error}");
        let error = projects("cluster = 'sample'\nscheme = 'blocks'").err().unwrap_or_default();
        assert!(error.contains("contradict") && error.contains("transport.cluster"), "{error}");
    }

    #[test]
    fn names_the_key_at_fault() {
        let cases = [
            ("receiver_angle = 0", "transport.receiver_angle: out of range; found 0; expected ster"),
            ("emitter_angle = inf", "transport.emitter_angle: not a finite number; found inf"),
            ("octree_angle = 0", "transport.octree_angle: out of range; found 0; expected steradian, above 0"),
            ("planarity = 1.1", "transport.planarity: out of range; found 1.1; expected 0 to 1"),
            ("form_factor_tolerance = 0.5", "transport.form_factor_tolerance: out of range"),
            (
                "hierarchy = 'octree'",
                "unknown variant `octree`, expected one of `face-clusters`, `median`, `butterfly`, `shrink-wrap`",
            ),
            ("budget = 0", "transport.budget: out of range; found 0; expected form factors of a frame, 1 to"),
            ("budget = -1", "transport.budget: out of range; found -1; expected form factors of a frame, 1 to"),
            ("walks = 5000000000", "transport.walks: out of range; found 5000000000; expected photons of a channel"),
            ("levels = 3", "transport.levels: only a hierarchy of 4-to-1 splits has levels; expected"),
            ("hierarchy = 'butterfly'\nlevels = 9", "transport.levels: out of range; found 9; expected 1 to 8"),
        ];
        for (text, message) in cases {
            let error = transport(text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
