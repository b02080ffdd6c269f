//! Animations of glTF: transforms and weights of nodes at a time, by linear, stepped or cubic interpolation.

use super::document::{Document, gone};
use super::tree::{Local, quaternion};
use super::{Checked, Files, Input};
use glam::{DQuat, DVec3};
use gltf::json::animation::{Animation, Interpolation, Property};
use gltf::json::validation::Checked::Valid;

/// Names of a file's animations, and how long they last, in seconds. One without a name is called by its number.
pub(super) fn names(document: &Document, files: &Files) -> Checked<Vec<(String, f64)>> {
    let lasting = |(number, animation): (usize, &Animation)| {
        let name = animation.name.clone().unwrap_or_else(|| number.to_string());
        Ok((name, duration(document, files, animation)?))
    };
    document.root.animations.iter().enumerate().map(lasting).collect()
}

/// The end of the last key of an animation, in seconds.
fn duration(document: &Document, files: &Files, animation: &Animation) -> Checked<f64> {
    let mut end = 0.0;
    for sampler in &animation.samplers {
        let times = document.vectors::<1>(files, sampler.input.value())?;
        end = times.iter().flatten().copied().filter(|time| time.is_finite()).fold(end, f64::max);
    }
    Ok(end)
}

/// Poses nodes as an animation has them at a time in seconds; it repeats when it is over.
pub(super) fn pose(document: &Document, files: &Files, number: usize, time: f64, locals: &mut [Local]) -> Checked<()> {
    let animation = document.root.animations.get(number).ok_or_else(|| gone("animation", number))?;
    let duration = duration(document, files, animation)?;
    let time = if duration > 0.0 { time.rem_euclid(duration) } else { 0.0 };
    for channel in &animation.channels {
        let fault = |what: &str| Input::new(what).key(format!("animations.{number}"));
        let Valid(path) = channel.target.path else { continue };
        let node = channel.target.node.value();
        let Some(local) = locals.get_mut(node) else { return Err(gone("node", node)) };
        let sampler = animation.samplers.get(channel.sampler.value());
        let sampler = sampler.ok_or_else(|| gone("sampler", channel.sampler.value()))?;
        let Valid(curve) = sampler.interpolation else { return Err(fault("an interpolation is not one of glTF's")) };
        let times: Vec<f64> = document.vectors::<1>(files, sampler.input.value())?.into_iter().flatten().collect();
        let (values, width) = document.numbers(files, sampler.output.value(), &[1, 3, 4])?;
        let size = match path {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => local.weights.len().max(targets(document, node)),
        };
        let keys = times.len() * if curve == Interpolation::CubicSpline { 3 } else { 1 };
        let fits = match path {
            Property::MorphTargetWeights => values.len() == keys * size,
            _ => width == size && values.len() == keys * size,
        };
        if !fits || times.is_empty() || size == 0 {
            let fault = fault("a sampler's output does not match its input").found(values.len());
            return Err(fault.expected(format!("{} numbers for {} times", keys * size, times.len())));
        }
        let value = sample(&times, &values, size, curve, path == Property::Rotation, time);
        match path {
            Property::Translation => local.translation = DVec3::from_slice(&value),
            Property::Scale => local.scale = DVec3::from_slice(&value),
            Property::Rotation => local.rotation = quaternion([value[0], value[1], value[2], value[3]]),
            Property::MorphTargetWeights => local.weights = value,
        }
    }
    Ok(())
}

/// The number of morph targets of a node's mesh.
fn targets(document: &Document, node: usize) -> usize {
    let mesh = document.root.nodes.get(node).and_then(|node| node.mesh);
    let mesh = mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
    let most = |mesh: &gltf::json::Mesh| mesh.primitives.iter().filter_map(|p| Some(p.targets.as_ref()?.len())).max();
    mesh.and_then(most).unwrap_or(0)
}

/// The value at a time, `size` numbers: before the first key that key's, after the last key that key's.
fn sample(times: &[f64], values: &[f64], size: usize, curve: Interpolation, turns: bool, time: f64) -> Vec<f64> {
    let cubic = curve == Interpolation::CubicSpline;
    // A key of a cubic spline is a tangent, a value and another tangent.
    let (stride, middle) = if cubic { (3 * size, size) } else { (size, 0) };
    let part = |key: usize, from: usize| &values[key * stride + from..][..size];
    let after = times.partition_point(|&other| other <= time);
    let (a, b) = (after.saturating_sub(1), after.min(times.len() - 1));
    let span = times[b] - times[a];
    if span.is_nan() || span <= 0.0 || curve == Interpolation::Step {
        return part(a, middle).to_vec();
    }
    let t = ((time - times[a]) / span).clamp(0.0, 1.0);
    let (from, to) = (part(a, middle), part(b, middle));
    match curve {
        Interpolation::CubicSpline => {
            let (t2, t3) = (t * t, t * t * t);
            let (leaving, arriving) = (part(a, 2 * size), part(b, 0));
            let blend = |k: usize| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * from[k]
                    + span * (t3 - 2.0 * t2 + t) * leaving[k]
                    + (3.0 * t2 - 2.0 * t3) * to[k]
                    + span * (t3 - t2) * arriving[k]
            };
            (0..size).map(blend).collect()
        }
        _ if turns => {
            let [from, to] = [from, to].map(|q| quaternion([q[0], q[1], q[2], q[3]]));
            DQuat::slerp(from, to, t).to_array().to_vec()
        }
        _ => from.iter().zip(to).map(|(from, to)| from + t * (to - from)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_pass_their_keys_and_end_at_the_outer_ones() {
        let (times, values) = ([1.0, 2.0, 4.0], [0.0, 10.0, 30.0]);
        let at = |curve, time| sample(&times, &values, 1, curve, false, time)[0];
        let line = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(|time| at(Interpolation::Linear, time));
        assert_eq!(line, [0.0, 0.0, 5.0, 10.0, 20.0, 30.0, 30.0]);
        let steps = [0.0, 1.9, 2.0, 3.9, 4.0].map(|time| at(Interpolation::Step, time));
        assert_eq!(steps, [0.0, 0.0, 10.0, 10.0, 30.0]);
        // A parabola, t^2 from 1 to 3, by its values and slopes.
        let cubic = [9.0, 1.0, 2.0, 6.0, 9.0, 9.0];
        for time in [1.0, 1.5, 2.25, 3.0] {
            let value = sample(&[1.0, 3.0], &cubic, 1, Interpolation::CubicSpline, false, time)[0];
            assert!((value - time * time).abs() < 1e-12, "{time}: {value}");
        }
        // Halfway of a quarter turn is an eighth, whichever of the two quaternions stands for the end.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for sign in [1.0, -1.0] {
            let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * half, sign * half];
            let turn = sample(&[0.0, 1.0], &keys, 4, Interpolation::Linear, true, 0.5);
            assert!((turn[2] - (std::f64::consts::PI / 8.0).sin()).abs() < 1e-9, "{turn:?}");
        }
    }
}
