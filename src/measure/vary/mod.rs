//! Choices of how the Vulkan API is used ([`AXES`]), each against the default: first what it computes, then its time.
//!
//! A choice changes no result, so a variant has to leave every buffer of the scene bit for bit as the default does,
//! after a first frame and two more. Where another optimisation of the shaders changes the arithmetic, each stage has
//! to conform to the reference instead.

mod first_frames;
mod proof;
mod strips;
mod subject;

use std::collections::BTreeSet;

pub use self::proof::{Computed, Proof, computed_steps, proof};
pub use self::strips::strips;
pub use self::subject::{Outcome, Subject, Tried};

use crate::error::{Error, Input, Result};
use crate::gpu::{AXES, Adapter, Axis, Choices, Optimization, group_is_open, kernel_names};
use crate::pipeline::frame;

/// One way to use the API.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Axis and value, `barriers=every`.
    pub name: String,
    /// How it uses the device.
    pub choices: Choices,
}

/// The variants of an axis that were asked for.
pub struct Asked {
    /// The axis.
    pub axis: &'static Axis,
    /// Its name as it was asked for, `group.link`.
    pub name: String,
    /// The name of the axis's default value.
    pub default: &'static str,
    /// The variants, without the default.
    pub variants: Vec<Variant>,
}

/// The variants that `NAME` or `NAME=V1,V2` mean: every value but the default where none is given. The axis `group`
/// also takes the name of a stage, `group.link=128`.
pub fn asked(text: &str) -> Result<Asked> {
    let (name, values) = text.split_once('=').map_or((text, None), |(name, values)| (name, Some(values)));
    let fault = |what: &str, found: &str, expected: String| -> Error {
        Input::new(what).key("--axis").found(found).expected(expected).into()
    };
    let (head, stage) = name.split_once('.').map_or((name, None), |(head, stage)| (head, Some(stage)));
    let all = || AXES.iter().map(|axis| axis.name).collect::<Vec<_>>().join(", ");
    let axis = AXES.iter().find(|axis| axis.name == head).ok_or_else(|| fault("no such axis", head, all()))?;
    if let Some(stage) = stage {
        if axis.name != "group" {
            return Err(fault("only the axis group takes a stage", name, axis.name.into()));
        }
        let open = kernel_names().filter(|kernel| group_is_open(kernel)).flat_map(|kernel| kernel.split('/'));
        let stages: BTreeSet<&str> = open.filter(|part| frame::stage(part).is_some()).collect();
        if !stages.contains(stage) {
            let stages = stages.into_iter().collect::<Vec<_>>();
            return Err(fault(
                "no stage of this name has a kernel that leaves its group open",
                stage,
                stages.join(", "),
            ));
        }
    }
    let known = || axis.values.iter().map(|value| value.name).collect::<Vec<_>>().join(", ");
    let chosen = match values {
        None => axis.values[1..].iter().collect(),
        Some(values) => {
            let found = |name| axis.value(name).ok_or_else(|| fault("no such value", name, known()));
            values.split(',').map(found).collect::<Result<Vec<_>>>()?
        }
    };
    let variant = |value: &&'static crate::gpu::Value| {
        let mut choices = Choices::default();
        (value.set)(&mut choices);
        if let Some(stage) = stage {
            choices.groups = choices.groups.into_values().map(|size| (stage.to_string(), size)).collect();
        }
        Variant { name: format!("{name}={}", value.name), choices }
    };
    let default = axis.values[0].name;
    let variants = chosen.iter().filter(|value| value.name != default).map(variant).collect();
    Ok(Asked { axis, name: name.into(), default, variants })
}

/// Why a device can't be used as a variant does, if it can't.
#[must_use]
pub fn lack(adapter: &Adapter, choices: &Choices) -> Option<String> {
    if cfg!(not(feature = "shaderc")) && choices.optimization != Optimization::default() {
        return Some("this build can't compile shaders: build it with `--features shaderc`".into());
    }
    let most = adapter.limits.group_invocations;
    let large = choices.groups.values().find(|size| **size > most);
    large.map(|_| format!("its groups have at most {most} invocations")).or_else(|| adapter.offers.lack(choices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Choices;

    #[test]
    fn an_axis_is_taken_at_its_word() {
        let names = |text: &str| asked(text).unwrap().variants.into_iter().map(|one| one.name).collect::<Vec<_>>();
        assert_eq!(names("shuffles"), ["shuffles=off"]);
        assert_eq!(names("barriers=events,every"), ["barriers=events", "barriers=every"]);
        assert_eq!(names("barriers=elided"), [""; 0], "the default is always there");
        let link = &asked("group.gather=128").unwrap().variants[0];
        assert_eq!(link.choices.groups, [("gather".to_string(), 128)].into());
        for (text, word) in [
            ("barrier", "descriptors, "),
            ("barriers=non", "elided, every"),
            ("barriers.link=every", "barriers"),
            ("group.nothing=32", "gather"),
            ("", "group, "),
        ] {
            let Err(Error::Input(fault)) = asked(text) else { panic!("{text}") };
            assert!(fault.expected.unwrap().contains(word), "{text}");
        }
    }

    #[test]
    fn values_of_an_axis_differ() {
        for axis in AXES {
            let chosen = |value: &crate::gpu::Value| {
                let mut choices = Choices::default();
                (value.set)(&mut choices);
                choices
            };
            let all: Vec<Choices> = axis.values.iter().map(chosen).collect();
            assert!((1..all.len()).all(|k| !all[..k].contains(&all[k])), "{}", axis.name);
            assert!(axis.name == "group" || all[0] == Choices::default(), "{}: the default comes first", axis.name);
        }
    }
}
