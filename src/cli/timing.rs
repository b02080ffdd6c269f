//! Arguments of commands that time frames: how many, how long, and what changes before each.

use clap::{Args, ValueEnum};

use milkglass::internals::pipeline::plan::Change;

/// Most frames.
pub(super) const MOST: u32 = 10_000;

/// How many frames to time, for how long, and what changes before each.
#[derive(Args)]
pub(super) struct TimingArguments {
    /// Timed frames, after those that warm up; `profile` divides those of a comparison into at least 9 starts [default:
    /// 11; where variants are compared, 128 of each].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST)))]
    pub(super) frames: Option<u32>,
    /// Time frames until the interval of each stage that takes 2 % or more of the frame is at most this wide on either
    /// side, such as 1%.
    #[arg(long, value_name = "SHARE", value_parser = share, conflicts_with = "frames")]
    pub(super) until: Option<f64>,
    /// Time no longer than this, in `vary` for each axis [default: 60 with `--until` and in `vary`].
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) budget: Option<f64>,
    /// Seed of the order of what is compared, and of the intervals [default: 1].
    #[arg(long, value_name = "N")]
    pub(super) seed: Option<u64>,
    /// What changes before each frame.
    #[arg(long, value_enum, default_value_t)]
    change: ChangeArgument,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum ChangeArgument {
    /// Everything: a frame from scratch.
    #[default]
    Everything,
    /// The lights.
    Light,
    /// The coefficients of all materials.
    Material,
    /// The camera.
    View,
}

impl TimingArguments {
    /// The seed.
    pub(super) fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// What changes before each frame.
    pub(super) fn change(&self) -> Change {
        match self.change {
            ChangeArgument::Everything => Change::EVERYTHING,
            ChangeArgument::Light => Change::LIGHT,
            ChangeArgument::Material => Change::MATERIAL,
            ChangeArgument::View => Change::VIEW,
        }
    }

    /// The name of what changes before each frame.
    pub(super) fn change_name(&self) -> String {
        self.change.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string())
    }
}

/// A share of 1, also in percent.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let number = |text: &str, scale: f64| Some(text.trim().parse::<f64>().ok()? * scale);
    let found = text.strip_suffix('%').map_or_else(|| number(text, 1.0), |text| number(text, 0.01));
    found.filter(|share| (1e-4..=0.5).contains(share)).ok_or_else(|| "expected 0.01% to 50%, or 0.0001 to 0.5".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    found.ok_or_else(|| "expected 0 to 1e6 seconds".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_also_percent() {
        assert_eq!((share("1%"), share("0.02"), share("2.5 %")), (Ok(0.01), Ok(0.02), Ok(0.025)));
        for bad in ["1", "0", "-1%", "60%", "", "%", "nan", "x"] {
            assert!(share(bad).is_err(), "{bad}");
        }
        assert!(seconds("nan").is_err() && seconds("-1").is_err() && seconds("0.5") == Ok(0.5));
    }
}
