//! How a command runs: what carries light, what is kept, and the call again for a shell.

use clap::{Args, ValueEnum};

use milkglass::gpu::Device;
use milkglass::pipeline::plan::{Mode, Options, ShadingMethod};

/// How to run.
#[derive(Args)]
pub(super) struct OptionArguments {
    /// What is kept from frame to frame; a single frame gains nothing by it.
    #[arg(long, value_enum, default_value_t)]
    mode: ModeArgument,
    /// How light is carried through the material.
    #[arg(long, value_enum, default_value_t)]
    transport: TransportArgument,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum ModeArgument {
    /// Everything from scratch in each frame.
    #[default]
    OnTheFly,
    /// Links are kept, and serve any light.
    Render,
    /// Links are kept while the shape changes, too: see `transport.budget`.
    Incremental,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum TransportArgument {
    /// The hierarchical method of Mertens et al. 2003.
    #[default]
    Hierarchy,
    /// The irradiance octree of Jensen and Buhler 2002: on the host's cores, whatever the device.
    Octree,
    /// Every face to every face.
    Brute,
    /// Not at all: what scatters once in layers, what opaque objects give back, and reflections.
    None,
    /// None: the curvature-dependent reflectance function of Kubo et al. 2010, at each pixel.
    Cdrf,
    /// None: Lambert's cosine, at each pixel.
    Lambert,
    /// Over the texture coordinates: irradiance blurred by Gaussians (d'Eon et al. 2007).
    TextureBlur,
}

impl OptionArguments {
    /// A scene's settings as this transport needs them: with texture coordinates where light is blurred over them.
    pub(super) fn of(&self, sets: &[String]) -> Vec<String> {
        let unwrap = matches!(self.transport, TransportArgument::TextureBlur).then(|| "transport.unwrap=true".into());
        unwrap.into_iter().chain(sets.iter().cloned()).collect()
    }

    pub(super) fn options(&self) -> Options {
        Options {
            transport: match self.transport {
                TransportArgument::Hierarchy => ShadingMethod::Hierarchy,
                TransportArgument::Octree => ShadingMethod::Octree,
                TransportArgument::Brute => ShadingMethod::Brute,
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

/// This very call, for a shell to repeat, on the device that it took.
pub(super) fn repeated(device: &Device) -> String {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    if !words.iter().any(|word| word == "--device" || word.starts_with("--device=")) {
        words.extend(["--device".into(), device.name().into()]);
    }
    std::iter::once("milkglass".to_string()).chain(words.iter().map(|word| quoted(word))).collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
pub(super) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
