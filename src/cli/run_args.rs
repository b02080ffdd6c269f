//! Options of a run: the transport, what is kept between frames; and the call as a shell command.

use clap::{Args, ValueEnum};

use milkglass::internals::pipeline::plan::{Mode, Options, ShadingMethod};

/// Transport and mode.
#[derive(Args, Clone, Copy)]
pub(super) struct OptionArguments {
    /// What is kept between frames; a single frame gains nothing from it.
    #[arg(long, value_enum, default_value_t)]
    pub(super) mode: ModeArgument,
    /// How light is transported through the material.
    #[arg(long, value_enum, default_value_t)]
    pub(super) transport: TransportArgument,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum ModeArgument {
    /// Everything from scratch in each frame.
    #[default]
    OnTheFly,
    /// Links are kept, and work for any light.
    Render,
    /// Links are also kept while the shape changes: see `transport.budget`.
    Incremental,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum TransportArgument {
    /// The hierarchical method of Mertens et al. 2003.
    #[default]
    Hierarchy,
    /// The irradiance octree of Jensen and Buhler 2002: on the host's cores, whatever the device.
    Octree,
    /// Every face to every face.
    Brute,
    /// Light walks through the object, photon by photon: the reference without approximations, with noise.
    Walk,
    /// The diffusion equation, solved on the object's own surface: nearer to the truth than the dipole.
    Diffusion,
    /// Diffusion in each object where it holds, the dipole by `hierarchy` in the others; `plan` says why.
    Auto,
    /// No transport: only single scattering in layers, opaque objects, and reflections.
    None,
    /// No transport: the curvature-dependent reflectance function of Kubo et al. 2010, at each pixel.
    Cdrf,
    /// No transport: Lambert's cosine, at each pixel.
    Lambert,
    /// In texture space: irradiance blurred by Gaussians (d'Eon et al. 2007).
    TextureBlur,
}

impl OptionArguments {
    /// The overrides of a scene; a blur in texture space also asks for texture coordinates.
    pub(super) fn of(&self, sets: &[String]) -> Vec<String> {
        let unwrap = matches!(self.transport, TransportArgument::TextureBlur).then(|| "transport.unwrap=true".into());
        unwrap.into_iter().chain(sets.iter().cloned()).collect()
    }

    /// The same arguments, for a process to start.
    pub(super) fn words(&self) -> Vec<String> {
        let name = |value: Option<clap::builder::PossibleValue>| {
            value.map(|value| value.get_name().to_string()).unwrap_or_default()
        };
        let (mode, transport) = (name(self.mode.to_possible_value()), name(self.transport.to_possible_value()));
        vec!["--mode".into(), mode, "--transport".into(), transport]
    }

    pub(super) fn options(&self) -> Options {
        Options {
            transport: match self.transport {
                TransportArgument::Hierarchy => ShadingMethod::Hierarchy,
                TransportArgument::Octree => ShadingMethod::Octree,
                TransportArgument::Brute => ShadingMethod::Brute,
                TransportArgument::Walk => ShadingMethod::Walk,
                TransportArgument::Diffusion => ShadingMethod::Diffusion,
                TransportArgument::Auto => ShadingMethod::Auto,
                TransportArgument::None => ShadingMethod::None,
                TransportArgument::Cdrf => ShadingMethod::Cdrf,
                TransportArgument::Lambert => ShadingMethod::Lambert,
                TransportArgument::TextureBlur => ShadingMethod::TextureBlur,
            },
            mode: match self.mode {
                ModeArgument::OnTheFly => Mode::OnTheFly,
                ModeArgument::Render => Mode::Render,
                ModeArgument::Incremental => Mode::Incremental,
            },
            ..Options::default()
        }
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
