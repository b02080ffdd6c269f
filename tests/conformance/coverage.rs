//! What coverage lists of a module is what a disassembler lists.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use crate::devices::on_devices;
use milkglass::internals::gpu::spirv;
use milkglass::internals::layout::BUFFER_IDS;
use milkglass::internals::state::DeviceState;
use milkglass::measure::fixtures::{EVERY_KERNEL, made};

/// The kind and name of everything.
type Names = BTreeSet<(&'static str, String)>;

/// What `spirv-dis` lists: what is declared, and the instructions of functions but those that only give them a form.
fn disassembled(module: &[u8]) -> Names {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(&file, module).unwrap();
    let output = Command::new("spirv-dis").args(["--no-color", "--raw-id"]).arg(file.path()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let (mut found, mut inside) = (Names::new(), false);
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        let line = line.split_once(" = ").map_or(line, |(_, line)| line);
        let parts: Vec<&str> = line.split_whitespace().collect();
        inside |= parts.first() == Some(&"OpFunction");
        let (kind, name) = match parts[..] {
            [] | [";", ..] => continue,
            ["OpCapability", name] => ("capability", name),
            ["OpExecutionMode" | "OpExecutionModeId", _, name, ..] => ("execution mode", name),
            ["OpExtension", name] => ("extension of SPIR-V", name.trim_matches('"')),
            ["OpExtInst", _, _, name, ..] if inside => ("instruction of GLSL.std.450", name),
            ["OpFunction" | "OpFunctionParameter" | "OpFunctionEnd" | "OpLabel" | "OpLine" | "OpNoLine", ..] => {
                continue;
            }
            [name, ..] if inside => ("instruction", name),
            _ => continue,
        };
        found.insert((kind, name.to_string()));
    }
    found
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn coverage_lists_what_a_disassembler_lists() {
    if Command::new("spirv-dis").arg("--version").output().is_err() {
        println!("LEFT OUT: there is no spirv-dis (Debian: spirv-tools)");
        return;
    }
    let fixtures = made(|name| EVERY_KERNEL.contains(&name)).unwrap();
    on_devices(|device| {
        // Of each module: what is listed, and what of that was executed.
        let mut modules: BTreeMap<String, [Names; 2]> = BTreeMap::new();
        for fixture in &fixtures {
            let mut copy = DeviceState::new(&device.counting(), false).unwrap();
            copy.upload(&fixture.state, BUFFER_IDS).unwrap();
            copy.run(&fixture.state, &fixture.steps).unwrap();
            for ([kernel, _], tally) in copy.kernels().tallies().unwrap() {
                let known = modules.entry(kernel).or_default();
                for (names, codes) in known.iter_mut().zip([tally.listed, tally.executed]) {
                    names.extend(codes.into_iter().map(|code| (code.kind(), code.name())));
                }
            }
        }
        let mut whole = 0;
        for (kernel, [listed, executed]) in &modules {
            let all = disassembled(spirv(kernel).unwrap());
            assert_eq!(*listed, all, "{kernel}");
            whole += usize::from(*executed == all);
        }
        assert!(modules.len() > 100 && 2 * whole > modules.len(), "{whole} of {} run in full", modules.len());
    });
}
