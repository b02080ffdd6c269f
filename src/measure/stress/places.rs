//! Extreme cases of meshes, of position and size, and of light.

use glam::DVec3;

use super::meshes::{both, doubled, even, mesh, reversed, sheet, turn, turned};
use super::solve::{Setup, scene};
use super::{Case, Kind, SHEET, SHEET_REASON, USUAL, USUAL_REASON, ZERO, within};
use crate::error::Result;
use crate::lighting::fresnel::transmittance;
use crate::scene::{Light, Source};

/// The base scene scaled by this factor, with the material's density scaled by its inverse.
fn scaled(factor: f64) -> Result<Setup> {
    let setup =
        Setup::new(&[&format!("object.0.size={factor:e}"), &format!("object.0.material.scale={:e}", 1.0 / factor)])?;
    Ok(setup.against(scene(&[])?, [1.0; 3]))
}

/// A sheet under light at this angle to its plane, against its scaled radiosity under normal incidence.
fn grazing(angle: f64) -> Result<Setup> {
    let mesh = || turned(sheet(&even(16), &even(16)));
    let (cos, sin) = (angle.cos(), angle.sin());
    let light = |x: f64, z: f64| Light::directional(turn(DVec3::new(x, 0.0, z)), [1.0; 3]);
    let mut above = Setup::new(&[])?.mesh(mesh());
    above.scene.lights = vec![light(0.0, 1.0)];
    let mut setup = Setup::new(&[])?.mesh(mesh());
    setup.scene.lights = vec![light(cos, sin)];
    let eta = setup.scene.objects[0].material.eta;
    Ok(setup.against(above.scene, eta.map(|eta| sin * transmittance(eta, sin) / transmittance(eta, 1.0))))
}

/// A point light of this intensity near the ball, against one of 1 W/sr.
fn lamp(intensity: f64) -> Result<Setup> {
    let lit = |intensity: f64| {
        let lamp = format!("light.0={{ type = 'point', position = [0.8, 0.5, 0.9], intensity = {intensity:e} }}");
        Setup::new(&[&lamp])
    };
    Ok(lit(intensity)?.against(lit(1.0)?.scene, [intensity; 3]))
}

/// Extreme meshes, positions and lights.
pub(super) static CASES: &[Case] = &[
    Case {
        name: "scene scale 1e-6",
        fallback: "none: internal lengths are scaled to the object by a power of two",
        bound: USUAL,
        brute: within(5e-5, 1.5e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| scaled(1e-6)),
    },
    Case {
        name: "scene scale 1e6",
        fallback: "none: internal lengths are scaled to the object by a power of two",
        bound: USUAL,
        brute: within(5e-5, 1.5e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| scaled(1e6)),
    },
    Case {
        name: "1e6 extents from the origin",
        fallback: "none: positions and lights are centred in f64 before they become f32",
        bound: USUAL,
        brute: within(5e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| {
            let lit = || {
                let sets =
                    ["light.0.irradiance=0.2", "light.1={ type='point', position=[0.8, -0.5, 0.9], intensity=1 }"];
                Setup::new(&sets)
            };
            let (mut setup, offset) = (lit()?, DVec3::new(1e6, -1e6, 7e5));
            setup.scene.objects[0].mesh.positions.iter_mut().for_each(|p| *p += offset);
            setup.scene.camera.position += offset;
            setup.scene.camera.target += offset;
            for light in &mut setup.scene.lights {
                if let Source::Point { position, .. } = &mut light.source {
                    *position += offset;
                }
            }
            Ok(setup.against(lit()?.scene, [1.0; 3]))
        }),
    },
    Case {
        name: "slivers of 1e-6",
        fallback: "none; import drops what is thinner than 1e-7",
        bound: SHEET,
        brute: within(5e-5, 8e-5),
        reason: SHEET_REASON,
        kind: Kind::Scene(|| Ok(Setup::new(&[])?.mesh(turned(sheet(&doubled(10, 1e-6), &even(10)))))),
    },
    Case {
        name: "zero-area faces",
        fallback: "import drops them; one that comes up emits nothing and receives like any other",
        bound: SHEET,
        brute: within(2e-5, 5e-5),
        reason: SHEET_REASON,
        kind: Kind::Scene(|| {
            let mut flat = turned(sheet(&even(8), &even(8)));
            flat.triangles.splice(5..5, [[3, 3, 3], [0, 1, 0]]);
            flat.triangles.extend([[20, 21, 21], [0, 1, 2], [0, 4, 8], [80, 80, 80]]);
            Ok(Setup::new(&[])?.mesh(mesh(flat.positions, flat.triangles)))
        }),
    },
    Case {
        name: "a slab as thin as z_r",
        fallback: "none: both sides are half spaces to the dipole, and distances are radial",
        bound: SHEET,
        brute: within(5e-5, 8e-5),
        reason: SHEET_REASON,
        kind: Kind::Scene(|| {
            let mut setup = Setup::new(&["object.0.shape=slab", "object.0.detail=12"])?;
            let material = &setup.scene.objects[0].material;
            let factor = 1.0 / (material.sigma_s_prime[1] + material.sigma_a[1]) / 0.2;
            setup.scene.objects[0].mesh.positions.iter_mut().for_each(|p| p.z *= factor);
            Ok(setup)
        }),
    },
    Case {
        name: "two coincident sheets",
        fallback: "none",
        bound: SHEET,
        brute: within(6e-5, 1e-4),
        reason: SHEET_REASON,
        kind: Kind::Scene(|| {
            let one = || turned(sheet(&even(14), &even(14)));
            let lights = ["light.1={ type='directional', direction=[-0.5, -0.3, -0.9], irradiance=[0.3, 0.9, 0.6] }"];
            Ok(Setup::new(&lights)?.mesh(both(one(), reversed(one()))))
        }),
    },
    Case {
        name: "light at grazing, 1e-3 rad",
        fallback: "none",
        bound: SHEET,
        brute: within(2e-4, 5e-4),
        reason: "as for any sheet; and a normal and a direction rounded to 2^-24 change a cosine of 1e-3 by 1e-4 of it, E by twice that",
        kind: Kind::Scene(|| grazing(1e-3)),
    },
    Case {
        name: "light tangent to a sheet",
        fallback: "zero: nothing enters at a cosine of 0",
        bound: ZERO,
        brute: ZERO,
        reason: "the cosine is exactly 0, and transmittance 0 there",
        kind: Kind::Scene(|| {
            Ok(Setup::new(&["light.0.direction=[1, 0, 0]"])?.mesh(sheet(&even(12), &even(12))).dark())
        }),
    },
    Case {
        name: "light tangent to a slab",
        fallback: "none: four of its sides take no light of their own",
        bound: USUAL,
        brute: within(3e-5, 1e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| Setup::new(&["object.0.shape=slab", "object.0.detail=12", "light.0.direction=[1, 0, 0]"])),
    },
    Case {
        name: "intensity 1e-30",
        fallback: "none: light is scaled by a power of two to about 1 before it becomes f32",
        bound: USUAL,
        brute: within(6e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| lamp(1e-30)),
    },
    Case {
        name: "intensity 1e30",
        fallback: "none: light is scaled by a power of two to about 1 before it becomes f32",
        bound: USUAL,
        brute: within(6e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| lamp(1e30)),
    },
    Case {
        name: "one lit face among dark ones",
        fallback: "none",
        bound: within(4e-5, 2e-4),
        brute: within(5e-4, 3e-3),
        reason: "a single emitter's errors do not average: brute force shows those of one sample up to chi = 0.1, the method the \
                 smaller ones of a link at a tolerance of 1e-3",
        kind: Kind::Scene(|| {
            let mut flat = turned(sheet(&even(16), &even(16)));
            flat.triangles[271].swap(1, 2);
            let mut setup = Setup::new(&[])?.mesh(flat);
            setup.scene.lights = vec![Light::directional(turn(-DVec3::Z), [1.0; 3])];
            Ok(setup)
        }),
    },
    Case {
        name: "one lit sliver among dark faces",
        fallback: "none",
        bound: within(8e-2, 4e-1),
        brute: within(6e-2, 4e-1),
        reason: "a sliver's edges cancel to 1e-5 of themselves in the edge form, so that the rounding of each is hundredths of \
                 its light; the CPU's doubles err by 1e-4",
        kind: Kind::Scene(|| {
            let mut flat = sheet(&doubled(10, 1e-5), &even(10));
            flat.triangles[2 * (19 * 4 + 9)].swap(1, 2);
            let mut setup = Setup::new(&[])?.mesh(flat);
            setup.scene.lights = vec![Light::directional(-DVec3::Z, [1.0; 3])];
            Ok(setup)
        }),
    },
    Case {
        name: "no light at all",
        fallback: "zero: no stage of the transport runs",
        bound: ZERO,
        brute: ZERO,
        reason: "buffers that no stage writes are zeroed",
        kind: Kind::Scene(|| Ok(Setup::new(&["light=[]"])?.dark())),
    },
];
