//! Stage `tone`: exposure, tone curve and sRGB curve to 8 bits a channel, by comparison with the least radiance of each
//! of the 255 steps. The host finds these from the curves, so that every device shows the same.

use rayon::prelude::*;

use super::picture::byte;
use crate::error::Result;
use crate::layout::BufferId;
use crate::scene::Tone;
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "tone",
    about: "each pixel as it is shown: exposure, tone curve and sRGB curve, 8 bits a channel",
    equation: "the number of thresholds that radiance reaches",
    writes: &[(BufferId::shown, Role::Output, Tolerance::Exact)],
    reason: "comparisons",
    sizes: &[(BufferId::shown, Size::Elements(State::pixels))],
    runs: |update| update.change.tone,
    ..super::stage(cpu, gpu)
};

/// The least radiance that is shown as 1, as 2, ... as 255; infinite if no radiance is.
#[must_use]
pub fn thresholds(exposure: f64, tone: Tone) -> Vec<f32> {
    let least = |step: u32| {
        // Floats of a positive sign are in the order of their bits.
        let (mut below, mut reached) = (0u32, f32::INFINITY.to_bits());
        while reached - below > 1 {
            let middle = below + (reached - below) / 2;
            let shown = u32::from(byte(f32::from_bits(middle), exposure, tone));
            *if shown >= step { &mut reached } else { &mut below } = middle;
        }
        f32::from_bits(reached)
    };
    (1..=255).into_par_iter().map(least).collect()
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let pixels = if data.mean.is_empty() { &data.radiance } else { &data.mean };
    let step = |x: f32| data.tones.partition_point(|&least| least <= x) as u32;
    let packed = |[r, g, b]: &[f32; 3]| step(*r) | step(*g) << 8 | step(*b) << 16;
    data.shown = pixels.par_iter().map(packed).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    pass.dispatch(None, &[u32::from(!data.mean.is_empty())], &[], data.radiance.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::picture::Picture;

    #[test]
    fn thresholds_show_what_the_curves_show() {
        for (exposure, tone) in [(1.0, Tone::Clip), (2.0, Tone::Filmic), (1e-30, Tone::Clip), (1e30, Tone::Filmic)] {
            let tones = thresholds(exposure, tone);
            assert!(tones.len() == 255 && tones.is_sorted());
            // Both sides of every step, and numbers that are no radiance.
            let near = |x: f32| [x.next_down(), x, x.next_up()];
            let values: Vec<f32> =
                tones.iter().copied().flat_map(near).chain([0.0, -0.0, -1.0, 1e38, f32::INFINITY]).collect();
            for x in values {
                let picture = Picture { exposure, tone, ..Picture::plain(1, 1, vec![[x; 3]]) };
                let step = tones.partition_point(|&least| least <= x) as u8;
                assert_eq!(picture.bytes()[0], step, "{x:e} at {exposure}, {tone:?}");
            }
        }
    }
}
