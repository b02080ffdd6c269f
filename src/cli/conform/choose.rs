//! Which fixtures or scenes are compared.

use regex::Regex;

use super::arguments::Arguments;
use milkglass::error::{Input, Result};
use milkglass::internals::session::run::CapacityHints;
use milkglass::measure::fixtures::{Fixture, fixture, fixtures, names};
use milkglass::scene::Scene;

/// A fixture or a scene to compare on.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Choice {
    /// A built-in fixture.
    Fixture(String),
    /// A scene.
    Scene(String),
}

impl Choice {
    /// Its name.
    pub(super) fn name(&self) -> &str {
        let (Self::Fixture(name) | Self::Scene(name)) = self;
        name
    }

    /// Builds its fixture.
    pub(super) fn make(&self, arguments: &Arguments) -> Result<Fixture> {
        let Self::Scene(name) = self else { return fixture(self.name()) };
        let sets = arguments.option_args.of(&arguments.sets);
        let scene = Scene::load_from(name, &sets, arguments.frame, &arguments.memory.files())?;
        let options = arguments.option_args.options();
        Fixture::new(name, &scene, options, CapacityHints::default()).map_err(|error| scene.placed(error))
    }
}

/// What the arguments choose, in order.
pub(super) fn chosen(arguments: &Arguments) -> Result<Vec<Choice>> {
    let all: Vec<Choice> = match arguments.scenes.is_empty() {
        true => names().into_iter().map(Choice::Fixture).collect(),
        false => arguments.scenes.iter().cloned().map(Choice::Scene).collect(),
    };
    let known: Vec<&str> = all.iter().map(Choice::name).collect();
    for name in &arguments.fixture {
        if !known.contains(&name.as_str()) {
            let fault = Input::new("there is no such fixture").key("--fixture").found(name);
            return Err(fault.expected(format!("one of\n  {}", known.join("\n  "))).into());
        }
    }
    let filter = arguments.filter.as_deref().map(expression).transpose()?;
    let scenes = !arguments.scenes.is_empty();
    let fits = |name: &str| {
        scenes
            || (name.contains(&arguments.only)
                && filter.as_ref().is_none_or(|filter| filter.is_match(name))
                && (arguments.fixture.is_empty() || arguments.fixture.iter().any(|own| own == name)))
    };
    let list: Vec<Choice> = all.iter().filter(|choice| fits(choice.name())).cloned().collect();
    if list.is_empty() {
        return match &arguments.filter {
            Some(filter) => {
                let fault = Input::new("no chosen fixture has a name that matches").key("--filter").found(filter);
                Err(fault.expected(format!("to match one of\n  {}", known.join("\n  "))).into())
            }
            // The message lists all names.
            None => fixtures(&arguments.only).map(|_| Vec::new()),
        };
    }
    let Some((part, parts)) = arguments.shard.as_deref().map(shard).transpose()? else { return Ok(list) };
    // Neighbours take about the same time, so they go to different parts.
    Ok(list.into_iter().enumerate().filter(|(index, _)| index % parts == part).map(|(_, choice)| choice).collect())
}

fn expression(text: &str) -> Result<Regex> {
    Regex::new(text).map_err(|error| {
        let why = error.to_string();
        let why = why.lines().last().unwrap_or_default().trim_start_matches("error: ").to_string();
        Input::new(format!("not a regular expression: {why}")).key("--filter").found(text).into()
    })
}

/// Part, from 0 on, and number of parts.
fn shard(text: &str) -> Result<(usize, usize)> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.parse::<usize>().ok()?, n.parse::<usize>().ok()?)));
    match numbers {
        Some((part, parts)) if (1..=parts).contains(&part) => Ok((part - 1, parts)),
        _ => Err(Input::new("not a part").key("--shard").found(text).expected("I/N with I from 1 to N").into()),
    }
}
