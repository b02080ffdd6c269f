//! Options of a run: the transport, what is kept between frames; and the call as a shell command.

use clap::{Args, ValueEnum};

use milkglass::internals::pipeline::plan::{Mode, Options, ShadingMethod};

/// Transport and mode.
#[derive(Args, Clone, Copy)]
pub(super) struct OptionArguments {
    /// What is kept between frames; a single frame gains nothing from it.
    #[arg(long, value_enum, default_value_t)]
    pub(super) mode: Mode,
    /// How light is transported through the material.
    #[arg(long, value_enum, default_value_t)]
    pub(super) transport: ShadingMethod,
}

impl OptionArguments {
    /// The overrides of a scene; a blur in texture space also asks for texture coordinates.
    pub(super) fn of(&self, sets: &[String]) -> Vec<String> {
        let unwrap = matches!(self.transport, ShadingMethod::TextureBlur).then(|| "transport.unwrap=true".into());
        unwrap.into_iter().chain(sets.iter().cloned()).collect()
    }

    /// The arguments as words of a command line: `--mode`, its value, `--transport`, its value.
    pub(super) fn words(&self) -> Vec<String> {
        let name = |value: Option<clap::builder::PossibleValue>| {
            value.map(|value| value.get_name().to_string()).unwrap_or_default()
        };
        let (mode, transport) = (name(self.mode.to_possible_value()), name(self.transport.to_possible_value()));
        vec!["--mode".into(), mode, "--transport".into(), transport]
    }

    pub(super) fn options(&self) -> Options {
        Options { transport: self.transport, mode: self.mode, ..Options::default() }
    }
}

/// This call as a shell command, with the device that it used.
pub(super) fn repeated(device: &str) -> String {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    if !words.iter().any(|word| word == "--device" || word.starts_with("--device=")) {
        words.extend(["--device".into(), device.into()]);
    }
    std::iter::once("milkglass".to_string()).chain(words.iter().map(|word| quoted(word))).collect::<Vec<_>>().join(" ")
}

/// A word, quoted for a shell where necessary.
pub(super) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
