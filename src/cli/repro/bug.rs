//! `replay --bug`: a report of a case for the developers of a driver.

use std::path::Path;

use crate::cli::run_args::quoted;
use milkglass::error::Result;
use milkglass::internals::gpu::{Adapter, Device, Kernel};
use milkglass::measure::repro::Case;
use milkglass::measure::repro::run::Found;
use milkglass::measure::results::{DeviceFacts, Verdict, system};
use milkglass::measure::verdict::{commit, watched};

/// How a case ended: with what was found, or without an end.
pub(super) type Ended = std::result::Result<Found, (Verdict, String)>;

/// The report, as Markdown: what happens, where, how to repeat it, and what the compiler says of the kernels. `device`
/// is none where compiling might end this process; `command` repeats the case, with its `replaced` kernels.
pub(super) fn report(
    (folder, case): (&Path, &Case),
    ended: &Ended,
    adapter: &Adapter,
    (layer, device): (Option<&str>, Option<&Device>),
    (command, replaced): (&str, &[String]),
) -> Result<String> {
    let about = &case.about;
    let kernels = case.kernels().into_iter().collect::<Vec<_>>().join(", ");
    let (what, lines) = match ended {
        Ok(found) if found.passes() => ("conforms", vec![format!("{} words are as expected", found.words)]),
        Ok(found) if found.wrong.is_empty() => ("breaks a rule of Vulkan", found.messages.clone()),
        Ok(found) => {
            let wrong = found.wrong.iter();
            let wrong = wrong.map(|(_, count, first)| format!("{count} words beyond tolerance: {first}"));
            ("differs from its reference", wrong.chain(found.messages.iter().cloned()).collect())
        }
        Err((Verdict::Hung, why)) => ("does not end", vec![why.clone()]),
        Err((Verdict::Crashed, why)) => ("ends the process", vec![why.clone()]),
        Err((_, why)) => ("loses the device", vec![why.clone()]),
    };
    let facts = DeviceFacts::new(adapter);
    let mut text = format!("# A compute shader {what} on {}: {kernels}\n\n", adapter.name);
    for line in lines {
        text += &format!("- {line}\n");
    }
    text += &format!(
        "\n{}: {}. Step {} of {}; {}.\n\n## Where\n\n",
        about.stage, about.does, about.step, about.fixture, about.dispatches
    );
    let made = commit(option_env!("MILKGLASS_COMMIT"));
    for (name, value) in [
        ("device", facts.device()),
        ("driver", facts.own_driver()),
        ("system", format!("{}; {}", system(), watched(layer))),
        ("program", format!("milkglass {}{made}", env!("CARGO_PKG_VERSION"))),
    ] {
        text += &format!("- {name}: {value}\n");
    }
    for kernel in replaced {
        text += &format!("- not the built-in kernel: {kernel}\n");
    }
    text += &format!(
        "\n## How to repeat it\n\nThe folder `{}` has SPIR-V, buffers before and after, and an AmberScript.\n\n```sh\n\
         {command}\n",
        folder.display(),
    );
    // Amber runs the modules in the folder.
    if replaced.is_empty() {
        let folder = quoted(&folder.display().to_string());
        text += &format!("cd {folder} && amber -d -v 1.2 -t spv1.5 case.amber\n");
    }
    text += "```\n\n## What the compiler says\n\n";
    text += &match device {
        None => "Not asked, since the case did not end well.\n".to_string(),
        Some(device) => statistics(case, device).unwrap_or_else(|error| format!("{error}\n")),
    };
    Ok(text)
}

/// What the driver's compiler says of each kernel: a list.
fn statistics(case: &Case, device: &Device) -> Result<String> {
    let mut lines: Vec<String> = Vec::new();
    for dispatch in &case.dispatches {
        let (name, words) = (&dispatch.kernel, dispatch.spirv.clone());
        let device = device.able(name, &words)?.with_statistics()?;
        let told = Kernel::with_lanes(&device, name, words, &dispatch.constants, dispatch.lanes)?.statistics()?;
        let told: Vec<String> = told.iter().map(|one| format!("{} {}", one.name, one.value)).collect();
        let told = if told.is_empty() {
            "this driver lacks VK_KHR_pipeline_executable_properties".into()
        } else {
            told.join(", ")
        };
        let line = format!("- {name} {:?}: {told}\n", dispatch.constants);
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    Ok(lines.concat())
}
