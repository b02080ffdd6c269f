//! Stage `irradiance_ratio`: the contrast, the ratio of the brightness of the entering light to that of the object.
//! In mode `render` lists are made as if light entered evenly everywhere, at its root mean square, so that they
//! depend only on shape, material, tolerance and this one number per channel, and serve every light of the same
//! contrast. It is rounded up in steps of a quarter octave, so that it seldom changes; when it does, lists are
//! rebuilt. Nothing depends on the light of earlier frames.

use crate::error::Result;
use crate::layout::{
    BufferId, COARSE_SAMPLES, CONTRAST_DOUBLINGS, CONTRAST_LEAST, CONTRAST_ROOTS, CONTRAST_STEPS, ObjectParams, Sample,
};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "irradiance_ratio",
    about: "contrast of the light: root mean square irradiance over the reference level, rounded up; kept lists hold for any light of this contrast",
    equation: "least q of 2^(k/4) with (q B_rms)^2 >= mean of E^2; the mean over the samples of `coarse_solve`",
    writes: &[(BufferId::counters, Role::Update, Tolerance::Exact)],
    reason: "a decision: additions, multiplications and comparisons in f32, the same everywhere",
    skip: |state| (!state.method.any_light).then_some("lists are made for the light of their frame"),
    ..super::stage(cpu, gpu)
};

/// The contrast of one channel, from the mean square of irradiance relative to its mean (`square`), and the light and
/// area of the whole object: `f32` decisions, as in the kernel. Numbers are scaled by a power of two before they are
/// squared, so that nothing underflows however dim an object is.
fn contrast(square: f32, [light, area]: [f32; 2], params: &ObjectParams, level: f32, channel: usize) -> f32 {
    let scale = scale(light);
    let (light, level) = (light * scale * params.tint[channel], level * scale * area);
    let light = square * (light * light);
    let mut octave = CONTRAST_LEAST;
    for step in 0..CONTRAST_STEPS {
        let q = octave * CONTRAST_ROOTS[step % 4];
        let reach = q * level;
        if reach * reach >= light {
            return q;
        }
        octave *= if step % 4 == 3 { 2.0 } else { 1.0 };
    }
    octave
}

/// The power of two that brings a number below 1 to at least 1.
fn scale(light: f32) -> f32 {
    let mut scale = 1.0f32;
    for _ in 0..CONTRAST_DOUBLINGS {
        scale *= if light * scale < 1.0 { 2.0 } else { 1.0 };
    }
    scale
}

fn cpu(state: &mut State, at: Scope) {
    let channels = state.object(at).groups[at.group].channels;
    let (base, _) = state.part(BufferId::moments, at);
    let data = &mut state.data;
    let square =
        data.samples.iter().fold(0.0f32, |sum, Sample { light, .. }| sum + light) * (1.0 / COARSE_SAMPLES as f32);
    let all = [data.moments[base].weight, data.clusters[0].area];
    for c in (0..3).filter(|c| channels >> c & 1 == 1) {
        data.counters[0].contrast[c] = contrast(square, all, &data.object_params[0], data.reference_level[0][c], c);
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[pass.object().groups[pass.at.group].channels], &[], 1)
}

#[cfg(test)]
mod tests {
    use crate::transport::blocks::irradiance_ratio::*;

    #[test]
    fn it_is_the_next_step_up() {
        let params = ObjectParams { tint: [1.0, 0.5, 1.0], ..ObjectParams::default() };
        let contrast = |light: f32, level: f32, c: usize| contrast(1.0, [light, 1.0], &params, level, c);
        assert_eq!(contrast(1.0, 1.0, 0), 1.0);
        assert_eq!(contrast(1.0, 0.99, 0), CONTRAST_ROOTS[1]);
        assert_eq!(contrast(2.0, 1.0, 1), 1.0);
        assert_eq!(contrast(3.0, 1.0, 0), 2.0 * CONTRAST_ROOTS[3]);
        // No light; beyond the last step; but dim light has the same contrast as bright light.
        assert_eq!((contrast(0.0, 1e-30, 0), contrast(1.0, 1e-30, 0)), (1.0 / 256.0, 1_048_576.0));
        assert_eq!(contrast(3e-25, 1e-25, 0), 2.0 * CONTRAST_ROOTS[3]);
        let steps = |q: f32| f64::from(q).log2() * 4.0;
        assert!(CONTRAST_ROOTS.iter().enumerate().all(|(k, &root)| (steps(root) - k as f64).abs() < 1e-6));
    }
}
