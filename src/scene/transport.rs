//! Settings of light transport: hierarchy, scheme and accuracy.

pub use super::choices::{ClusterForm, Distance, Hierarchy, Near, Oracle, Receivers, Scheme};
use super::file::TransportFile;
use super::local::{Cdrf, Kappa};
use super::range::{self, Checked};
use crate::error::Input;
use crate::layout::MOST_STEPS;

/// Default of the relative error of the radiosity.
pub const TOLERANCE: f64 = 1e-3;
/// Default of how much an emitter's solid angle may vary over a receiver's children, steradian.
pub const RECEIVER_ANGLE: f64 = 0.05;
/// Default of the largest solid angle of a cluster that emits over a link, steradian.
pub const EMITTER_ANGLE: f64 = 0.07;
/// Default of the smallest ratio of projected to true area of an emitter that may be linked.
pub const PLANARITY: f64 = 0.3;
/// Default of the relative error allowed in one form factor.
pub const FORM_FACTOR_TOLERANCE: f64 = 1e-2;

/// Default of the estimated noise of a random walk.
pub const WALK_ERROR: f64 = 0.02;

/// Most photons of a channel.
pub const MOST_WALKS: u32 = 1_000_000_000;

/// Default of the solid angle from which a cell of the octree is opened, steradian.
pub const OCTREE_ANGLE: f64 = 0.2;

/// The validated settings of light transport.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transport {
    /// How light is transported from clusters to receivers.
    pub scheme: Scheme,
    /// The reason for that scheme, printed with the plan.
    pub because: &'static str,
    /// Scheme blocks: target relative error of the radiosity (L2, worst channel), 1e-6 to 0.5.
    pub tolerance: f64,
    /// Scheme blocks: order of the emitters' moments, 0 to 2.
    pub order: u32,
    /// How faces are grouped into clusters.
    pub hierarchy: Hierarchy,
    /// Hierarchies butterfly and shrink-wrap: levels of 4-to-1 subdivision of the base, 1 to 8, if given.
    pub levels: Option<u32>,
    /// Where radiosity is computed for a picture.
    pub receivers: Receivers,
    /// Maximum levels of 4-to-1 subdivision where irradiance varies over a triangle, 0 to 4.
    pub subdivide: u32,
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
    pub walks: Option<u32>,
    /// Diffusion: steps of the solver instead of `tolerance`, 1 to 30, if given.
    pub steps: Option<u32>,
    /// Mode incremental: maximum number of form factors that a frame computes for links that are kept, at least 1;
    /// unlimited if omitted.
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

    /// Checks `[transport]`.
    pub(super) fn check(file: &TransportFile) -> Checked<Self> {
        let (scheme, because) = scheme(file)?;
        let tree = match scheme {
            Scheme::Blocks => Hierarchy::Median,
            Scheme::Links => Hierarchy::FaceClusters,
        };
        if scheme == Scheme::Links && file.receivers == Receivers::Pixels {
            let fault = Input::new("scheme links has no receivers at pixels").key("transport.receivers");
            return Err(fault.found("pixels").expected("faces or auto, or scheme = \"blocks\""));
        }
        let angle = |key, value| range::number(key, value, |x| x > 0.0, "steradian, above 0");
        Ok(Self {
            scheme,
            because,
            receivers: file.receivers,
            subdivide: range::number("transport.subdivide", f64::from(file.subdivide), |x| x <= 4.0, "0 to 4")? as u32,
            tolerance: range::number(
                "transport.tolerance",
                file.tolerance,
                |x| (1e-6..=0.5).contains(&x),
                "1e-6 to 0.5",
            )?,
            order: range::number("transport.order", f64::from(file.order), |x| x <= 2.0, "0, 1 or 2")? as u32,
            hierarchy: file.hierarchy.unwrap_or(tree),
            levels: levels(file)?,
            distance: file.distance,
            near: file.near,
            cluster: cluster(file)?,
            receiver_angle: angle("transport.receiver_angle", file.receiver_angle.unwrap_or(RECEIVER_ANGLE))?,
            emitter_angle: angle("transport.emitter_angle", file.emitter_angle.unwrap_or(EMITTER_ANGLE))?,
            planarity: range::number(
                "transport.planarity",
                file.planarity.unwrap_or(PLANARITY),
                |x| (0.0..=1.0).contains(&x),
                "0 to 1",
            )?,
            form_factor_tolerance: range::number(
                "transport.form_factor_tolerance",
                file.form_factor_tolerance,
                |x| (1e-4..=1e-1).contains(&x),
                "1e-4 to 1e-1",
            )?,
            octree_angle: angle("transport.octree_angle", file.octree_angle)?,
            walk_error: range::number(
                "transport.walk_error",
                file.walk_error,
                |x| (1e-4..=1.0).contains(&x),
                "1e-4 to 1",
            )?,
            walks: count("transport.walks", file.walks, MOST_WALKS, "photons of a channel, 1 to 1000000000")?,
            steps: count("transport.steps", file.steps, MOST_STEPS as u32, "steps of the solver, 1 to 30")?,
            budget: count("transport.budget", file.budget, u32::MAX, "form factors of a frame, 1 to 4294967295")?,
            cdrf: file.cdrf,
            cdrf_table: range::number(
                "transport.cdrf_table",
                f64::from(file.cdrf_table),
                |x| (8.0..=1024.0).contains(&x),
                "8 to 1024",
            )? as u32,
            curvature: file.curvature,
            unwrap: file.unwrap,
            blur_texture: range::number(
                "transport.blur_texture",
                f64::from(file.blur_texture),
                |x| (16.0..=2048.0).contains(&x),
                "16 to 2048",
            )? as u32,
        })
    }
}

/// How near clusters are evaluated, if given.
fn cluster(file: &TransportFile) -> Checked<Option<ClusterForm>> {
    if file.near == Near::PointSampling && file.cluster == Some(ClusterForm::Projected) {
        let fault = Input::new("point samples are of triangles; a cluster takes one").key("transport.cluster");
        return Err(fault.found("projected").expected("sample, or transport.near = \"exact\""));
    }
    Ok(file.cluster)
}

/// A whole number of at least 1, if it is given.
fn count(key: &'static str, given: Option<i64>, most: u32, expected: &'static str) -> Checked<Option<u32>> {
    let number = |n: i64| range::number(key, n as f64, |n| (1.0..=f64::from(most)).contains(&n), expected);
    Ok(given.map(number).transpose()?.map(|n| n as u32))
}

/// Levels of subdivision of a base, for hierarchies that have one.
fn levels(file: &TransportFile) -> Checked<Option<u32>> {
    let split = matches!(file.hierarchy, Some(Hierarchy::Butterfly | Hierarchy::ShrinkWrap));
    let key = "transport.levels";
    match file.levels {
        None => Ok(None),
        Some(_) if !split => {
            let fault = Input::new("only a hierarchy of 4-to-1 splits has levels").key(key);
            Err(fault.expected("hierarchy = \"butterfly\" or \"shrink-wrap\""))
        }
        Some(levels) => {
            let levels = u32::try_from(levels).ok().filter(|levels| (1..=8).contains(levels));
            let found = file.levels.unwrap_or_default();
            levels.map(Some).ok_or_else(|| Input::new("out of range").key(key).found(found).expected("1 to 8"))
        }
    }
}

/// The scheme that the keys ask for, and the reason; contradicting keys are an error.
fn scheme(file: &TransportFile) -> Checked<(Scheme, &'static str)> {
    let angles = file.receiver_angle.or(file.emitter_angle).or(file.planarity).is_some();
    let mut reasons = Vec::new();
    if let Some(scheme) = file.scheme {
        reasons.push((scheme, "transport.scheme says so"));
    }
    if let Some(oracle) = file.oracle {
        let scheme = if oracle == Oracle::Contribution { Scheme::Blocks } else { Scheme::Links };
        reasons.push((scheme, "transport.oracle belongs to it"));
    }
    if angles {
        reasons.push((Scheme::Links, "receiver_angle, emitter_angle or planarity is given"));
    }
    if file.distance == Distance::Table1 {
        reasons.push((Scheme::Links, "moments work with radial distances only, transport.distance is table1"));
    }
    if file.cluster.is_some() {
        reasons.push((Scheme::Links, "transport.cluster belongs to it"));
    }
    if file.near == Near::PointSampling {
        reasons
            .push((Scheme::Links, "transport.near is point-sampling, which is there to compare the paper's own with"));
    }
    let chosen =
        reasons.first().copied().unwrap_or((Scheme::Blocks, "it meets transport.tolerance with the least work"));
    match reasons.iter().find(|(scheme, _)| *scheme != chosen.0) {
        Some((_, other)) => Err(Input::new("keys of [transport] contradict each other")
            .found(format!("{} for one scheme, {other} for the other", chosen.1))
            .expected(
                "keys of one scheme: blocks (tolerance, order) or links (receiver_angle, emitter_angle, planarity)",
            )),
        None => Ok(chosen),
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
        assert_eq!((transport.hierarchy, transport.scheme), (Hierarchy::FaceClusters, Scheme::Links));
        assert_eq!((transport.distance, transport.near), (Distance::Table1, Near::Exact));
        assert_eq!((transport.receiver_angle, transport.planarity), (RECEIVER_ANGLE, PLANARITY));
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
            ("levels = 3", "transport.levels: only a hierarchy of 4-to-1 splits has levels; expected"),
            ("hierarchy = 'butterfly'\nlevels = 9", "transport.levels: out of range; found 9; expected 1 to 8"),
        ];
        for (text, message) in cases {
            let error = transport(text).err().unwrap_or_default();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
