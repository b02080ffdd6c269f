//! `milkglass eval`: evaluates formulas for each row of a file, to check the kernels from outside.

use std::path::PathBuf;

use clap::Args;

use super::{DeviceArgument, MemoryArgument, check_messages, validation, write};
use milkglass::error::{Input, Result};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::eval::{Kind, answers};
use milkglass::scene::Fresnel;

/// Arguments of `eval`.
#[derive(Args)]
#[command(after_help = "Example: milkglass eval form-factor rows.csv -o values.csv --device cpu\n\n\
    form-factor: v0x,v0y,v0z,v1x,...,v2z,xox,xoy,xoz,sigma_s_prime,sigma_a,eta -> value (Table 1, displaced \
    sources, no clamp), value_radial\nprofile: r,sigma_s_prime,sigma_a,eta -> value, R_d(r)\n\
    cdrf: cos_theta,sigma (radian) -> value, f of Kubo et al. 2010, equation 1, periodic\n\
    layered: light (directional or point), layers, thickness1..4, sigma_s1..4, sigma_t1..4, g1..4 (blank where unused), \
    lx,ly,lz,intensity,wox,woy,woz -> value, radiance at the origin of a flat slab under z = 0 towards wo")]
pub struct Arguments {
    /// What to evaluate.
    kind: Kind,
    /// The rows: a CSV file with a header.
    input: PathBuf,
    /// The output: the input's columns, followed by the values.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Formula for the diffuse Fresnel reflectance in the boundary condition.
    #[arg(long, value_enum, default_value = "paper")]
    fresnel: Fresnel,
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    memory: MemoryArgument,
}

/// Bytes of memory that a byte of the input file needs.
const COPIES: u64 = 128;

/// Evaluates every row and writes the results beside the input's columns.
pub fn run(arguments: &Arguments) -> Result<()> {
    let file = &arguments.input;
    if file == &arguments.output {
        return Err(Input::new("the output would replace the input").key("-o").found(file.display()).into());
    }
    ready([("-o", Some(&arguments.output))])?;
    super::paths::announce_pipe(file);
    let text = arguments.memory.files().stream(file, COPIES).map_err(|e| Input::new(e.to_string()).file(file))?;
    let mut opened = None;
    let open = || arguments.device.open(validation()).inspect(|device| opened.clone_from(device));
    let bytes = answers(arguments.kind, arguments.fresnel, file, &text, open)?;
    check_messages(opened.as_ref())?;
    write(&arguments.output, bytes)
}
