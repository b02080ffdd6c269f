//! Extreme cases of materials: albedo, index of refraction, mean free path.

use super::solve::Setup;
use super::{Case, Kind, USUAL, USUAL_REASON, ZERO, within};
use crate::error::Result;

/// The reason of the cases in which light leaves through the face where it entered.
const ALONE_REASON: &str = "every face lights itself alone: no cluster counts; a centre rounded to f32 lies hundredths \
                            of a mean free path off its plane, and takes half the square of that";

/// The base scene with this index of refraction.
fn refracting(eta: f64) -> Result<Setup> {
    Setup::new(&[&format!("object.0.material.eta={eta:e}")])
}

/// The base scene, 1 mm across, with this mean free path, mm.
fn free_path(mm: f64) -> Result<Setup> {
    let (s, a) = (0.9 / mm, 0.1 / mm);
    Setup::new(&[
        &format!("object.0.material.sigma_s_prime=[{s:e}, {s:e}, {:e}]", s + a),
        &format!("object.0.material.sigma_a=[{a:e}, {:e}, 0]", 1e-3 * a),
    ])
}

/// Extreme materials on the ball.
pub(super) static CASES: &[Case] = &[
    Case {
        name: "alpha' 0",
        fallback: "zero: what is absorbed at once does not come back",
        bound: ZERO,
        brute: ZERO,
        reason: "the strength alpha' / (4 pi) is 0, and every sum of zeros is",
        kind: Kind::Scene(|| Ok(Setup::new(&["object.0.material.sigma_s_prime=0"])?.dark())),
    },
    Case {
        name: "alpha' 1-1e-9",
        fallback: "none",
        bound: USUAL,
        brute: within(6e-5, 1.5e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| Setup::new(&["object.0.detail=3", "object.0.material.sigma_a=[22e-9, 26e-9, 30e-9]"])),
    },
    Case {
        name: "sigma_a 0",
        fallback: "none: sigma_tr is 0, and e^0 is 1",
        bound: USUAL,
        brute: within(8e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| Setup::new(&["object.0.material.sigma_a=0"])),
    },
    Case {
        name: "sigma_a 1e6 sigma_s'",
        fallback: "none",
        bound: within(4e-5, 2e-4),
        brute: within(1.5e-6, 3e-6),
        reason: "hardly any light comes back, and that from near: expansions beyond count as parts in a million",
        kind: Kind::Scene(|| {
            let sets = ["object.0.material.sigma_s_prime=[1e-6, 1e-5, 2e-5]", "object.0.material.sigma_a=[1, 10, 20]"];
            Setup::new(&sets)
        }),
    },
    Case {
        name: "eta 0.7",
        fallback: "none: F_int is that of the thin side, and beyond the critical angle nothing enters",
        bound: USUAL,
        brute: within(5e-5, 2e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(0.7)),
    },
    Case {
        name: "eta 1",
        fallback: "none: F_int is 0 and A is 1, without a formula",
        bound: USUAL,
        brute: within(5e-5, 1.5e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(1.0)),
    },
    Case {
        name: "eta 1.0001",
        fallback: "F_int by its series in eta - 1: the closed form cancels below 1.001",
        bound: USUAL,
        brute: within(5e-5, 1.5e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(1.0001)),
    },
    Case {
        name: "eta 2.4",
        fallback: "none",
        bound: USUAL,
        brute: within(8e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(2.4)),
    },
    Case {
        name: "eta 4",
        fallback: "none",
        bound: USUAL,
        brute: within(8e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(4.0)),
    },
    Case {
        name: "eta 0.5",
        fallback: "none: as at 0.7",
        bound: USUAL,
        brute: within(6e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(0.5)),
    },
    Case {
        name: "eta 5",
        fallback: "none",
        bound: USUAL,
        brute: within(8e-5, 3e-4),
        reason: USUAL_REASON,
        kind: Kind::Scene(|| refracting(5.0)),
    },
    Case {
        name: "mean free path 1e-6 of the object",
        fallback: "none",
        bound: within(1.5e-4, 4e-4),
        brute: within(1.5e-4, 4e-4),
        reason: ALONE_REASON,
        kind: Kind::Scene(|| free_path(1e-6)),
    },
    Case {
        name: "mean free path 1e-9 of the object",
        fallback: "brought to 1e-6 of the object with its albedo kept: light leaves where it enters either way",
        bound: within(1.5e-4, 4e-4),
        brute: within(1.5e-4, 4e-4),
        reason: ALONE_REASON,
        kind: Kind::Scene(|| Ok(free_path(1e-9)?.against(free_path(1e-6)?.scene, [1.0; 3]))),
    },
    Case {
        name: "mean free path 1e6 of the object",
        fallback: "none",
        bound: within(8e-7, 8e-7),
        brute: within(6e-7, 6e-7),
        reason: "the kernel is the same for all pairs of faces, so that clusters cost nothing: rounding alone",
        kind: Kind::Scene(|| free_path(1e6)),
    },
];
