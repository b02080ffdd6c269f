//! The deformations of an object, each with the amount that a slider changes.

use milkglass::scene::{Deform, Object};

/// How far an object is deformed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Amount {
    /// The deformation, as scene files call it.
    pub(super) kind: &'static str,
    /// The key of the amount in the deformation.
    pub(super) key: &'static str,
    /// The amount, in the unit of scene files.
    pub(super) value: f64,
    /// The slider's ends.
    pub(super) ends: [f64; 2],
}

/// The amounts of an object's deformations, in the order of its file; `extent` is its largest extent, scene units.
/// A skin has none.
pub(super) fn amounts(object: &Object, extent: f64) -> Vec<Amount> {
    let amount = |kind, key, value, most: f64| Amount { kind, key, value, ends: [-most, most] };
    let of_deform = |deform: &Deform| {
        Some(match deform {
            Deform::Twist { angle, .. } => amount("twist", "angle", angle.to_degrees(), 360.0),
            Deform::Bend { angle, .. } => amount("bend", "angle", angle.to_degrees(), 180.0),
            Deform::Bump { height, .. } => amount("bump", "height", *height, extent / 2.0),
            Deform::Noise { amplitude, .. } => amount("noise", "amplitude", *amplitude, extent / 4.0),
            Deform::Morph { weight, .. } => amount("morph", "weight", *weight, 2.0),
            Deform::Skin { .. } => return None,
        })
    };
    object.deforms.iter().filter_map(of_deform).collect()
}

/// Sets the amount of a deformation, by its place among [`amounts`].
pub(super) fn set_amount(object: &mut Object, index: usize, to: f64) {
    let mut all = object.deforms.iter_mut().filter(|deform| !matches!(deform, Deform::Skin { .. }));
    match all.nth(index) {
        Some(Deform::Twist { angle, .. } | Deform::Bend { angle, .. }) => *angle = to.to_radians(),
        Some(Deform::Bump { height: amount, .. } | Deform::Noise { amplitude: amount, .. }) => *amount = to,
        Some(Deform::Morph { weight, .. }) => *weight = to,
        Some(Deform::Skin { .. }) | None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::scene::Scene;

    #[test]
    fn an_amount_is_the_number_of_the_scene_file() {
        for name in ["twist", "torus", "bump", "noise"] {
            let scene = Scene::load_at(name, &[], 30.0).unwrap();
            let all = amounts(&scene.objects[0], 80.0);
            assert!(!all.is_empty(), "{name}");
            for (index, known) in all.iter().enumerate() {
                let set = format!("object.0.deform.{index}.{}={:?}", known.key, known.value);
                let again = Scene::load_at(name, &[set], 30.0).unwrap();
                let found = &amounts(&again.objects[0], 80.0)[index];
                assert!(found.kind == known.kind && (found.value - known.value).abs() < 1e-9, "{name}: {found:?}");
                let set = format!("object.0.deform.{index}.{}=1.25", known.key);
                let mut changed = scene.objects[0].clone();
                set_amount(&mut changed, index, 1.25);
                assert_eq!(changed.deforms, Scene::load_at(name, &[set], 30.0).unwrap().objects[0].deforms, "{name}");
            }
        }
    }
}
