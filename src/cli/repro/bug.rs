//! `replay --bug`: a report of a case for the developers of a driver.

use std::collections::BTreeSet;
use std::path::Path;

use milkglass::error::Result;
use milkglass::internals::gpu::{Adapter, Device, Kernel};
use milkglass::measure::repro::Case;
use milkglass::measure::repro::run::Found;
use milkglass::measure::results::{DeviceFacts, Verdict, system};
use milkglass::measure::verdict::{commit, watched};

/// How a case ended: with what was found, or without an end.
pub(super) type Ended = std::result::Result<Found, (Verdict, String)>;

/// The report, as Markdown: what happens, where, how to repeat it, and what the compiler says of the kernels. `device`
/// is none where compiling might end this process.
pub(super) fn report(
    (folder, case): (&Path, &Case),
    ended: &Ended,
    adapter: &Adapter,
    (layer, device): (Option<&str>, Option<&Device>),
) -> Result<String> {
    let about = &case.about;
    let kernels: BTreeSet<&str> = case.dispatches.iter().map(|dispatch| dispatch.kernel.as_str()).collect();
    let kernels = kernels.into_iter().collect::<Vec<_>>().join(", ");
    let (what, lines) = match ended {
        Ok(found) if found.passes() => ("conforms", vec![format!("{} words are as expected", found.words)]),
        Ok(found) => {
            let wrong = found.wrong.iter();
            let wrong = wrong.map(|(_, count, first)| format!("{count} words beyond tolerance: {first}"));
            ("differs from its reference", wrong.chain(found.messages.iter().cloned()).collect())
        }
        Err((verdict, why)) => (verdict.name(), vec![why.clone()]),
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
    text += &format!(
        "\n## How to repeat it\n\nThe folder `{0}` has SPIR-V, buffers before and after, and an AmberScript.\n\n```sh\n\
         milkglass replay {0} --device {1}\ncd {0} && amber -d -v 1.2 -t spv1.5 case.amber\n```\n\n\
         ## What the compiler says\n\n",
        folder.display(),
        adapter.number
    );
    text += &match device {
        None => "Not asked, since the case did not end well.\n".to_string(),
        Some(device) => statistics(case, device)?,
    };
    Ok(text)
}

/// What the driver's compiler says of each kernel: a list.
fn statistics(case: &Case, device: &Device) -> Result<String> {
    let device = device.with_statistics()?;
    let mut lines: Vec<String> = Vec::new();
    for dispatch in &case.dispatches {
        let (name, words) = (&dispatch.kernel, dispatch.spirv.clone());
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
