//! Shading by curvature on extreme curvatures: a device's picture against the reference's.

use super::{Found, Plant, Worst};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{Cdrf, Scene};
use crate::session::run::Session;
use crate::shading::smooth_curvature::kappa;

/// Pictures in closed form and from the table, against the reference's.
pub(super) fn run(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let mut tabled = scene.clone();
    tabled.transport.cdrf = Cdrf::Table;
    Ok([method(scene, device, plant)?, method(&tabled, device, None)?])
}

fn method(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<Found> {
    let options = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
    let picture = |device: Option<&Device>| {
        let mut session = Session::new(scene, device, options)?;
        session.frame(Change::EVERYTHING)?;
        session.fetch(&[BufferId::curvature, BufferId::smooth_kappa, BufferId::radiance])?;
        let data = &session.state().data;
        let kappa: Vec<_> = (0..data.curvature.len()).map(|v| [kappa(data, v); 3]).collect();
        Ok::<_, Error>((data.curvature.clone(), kappa, data.radiance.clone()))
    };
    let (.., expected) = picture(None)?;
    let (curvature, kappa, mut radiance) = picture(device)?;
    if let Some(plant) = plant {
        plant.apply(&mut radiance);
    }
    let mut found = Found::default();
    found.look("kappa", &kappa);
    found.look("radiance", &radiance);
    let sound = |bend: &crate::layout::Curvature| bend.mean.is_finite() && bend.gaussian.is_finite();
    if !curvature.iter().all(sound) {
        found.faults.push("a curvature is not finite".into());
    }
    // The largest error is a share of what is seen.
    let shown = expected.iter().flatten().filter(|x| **x > 0.0).count();
    found.error = Worst::of(expected.into_iter().flatten().zip(radiance.into_iter().flatten()), shown);
    Ok(found)
}
