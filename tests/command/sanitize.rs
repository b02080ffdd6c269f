//! `conform --sanitize` and `conform --device interpreter`.

use crate::shell::{bad, folder, good};

/// A ball small enough to run quickly.
const BALL: &str = "[camera]\nsize = [16, 12]\n[[object]]\nshape = 'sphere'\ndetail = 1\nsize = 10\n\
                    material = { preset = 'marble' }\n[[light]]\ntype = 'directional'\ndirection = [1, 1, 1]\n\
                    irradiance = 3\n[transport]\nreceivers = 'faces'\n";

#[test]
fn a_sound_kernel_passes_and_a_faulty_one_is_named_with_its_line() {
    let here = folder(&[("a.toml", BALL)]);
    let (out, _) = good(&here, "conform a.toml --sanitize --stage push,pull");
    assert!(out.contains("on 1 scene:") && out.contains("nothing is wrong"), "{out}");
    let (text, _) = good(&here, "shader transport/blocks/push");
    let text = text.replace("radiosity[self.face] =", "radiosity[self.face + 1] =");
    std::fs::write(here.path().join("own.comp"), &text).unwrap();
    let line = text.lines().position(|line| line.contains("self.face + 1]")).unwrap() + 1;
    let command = "conform a.toml --sanitize --replace transport/blocks/push=own.comp";
    bad(&here, command, 1, &["fault"]);
    let output = crate::shell::program(&here, command).output().unwrap();
    let (out, _) = crate::shell::said(&output);
    let named = format!("out of bounds: transport/blocks/push: own.comp:{line} (OpStore)");
    assert!(out.contains(&named) && out.contains("writes radiosity["), "{named} is not in\n{out}");
}

#[test]
fn the_interpreter_is_a_device() {
    let here = folder(&[("a.toml", BALL)]);
    let (out, _) = good(&here, "conform a.toml --device interpreter --stage push,link --json r.json");
    assert!(out.contains("2 comparisons, all conform"), "{out}");
    assert!(crate::shell::read(&here, "r.json").contains("\"device\": \"interpreter\""));
}

#[test]
fn a_profile_on_the_interpreter_counts_and_times_nothing() {
    let here = folder(&[("a.toml", BALL)]);
    let (out, _) = good(&here, "profile a.toml --set object.0.detail=0 --device interpreter --by kernel --csv c.csv");
    assert!(out.contains("nothing is timed") && out.contains("transport/blocks/push "), "{out}");
    let csv = crate::shell::read(&here, "c.csv");
    let row = csv.lines().find(|row| row.contains("transport/blocks/push")).unwrap();
    // The scene, the kernel, a dispatch, a group of 64.
    assert!(row.starts_with("a,transport/blocks/push,1,64,"), "{csv}");
    for (option, key) in [("--frames 3", "--frames"), ("--seed 1", "--seed"), ("--fail-slower 1%", "--fail-slower")] {
        bad(&here, &format!("profile a.toml --device interpreter {option}"), 2, &[key, "times nothing"]);
    }
    bad(&here, "profile a.toml --device interpreter --save r.json", 2, &["--json", "times nothing"]);
    bad(&here, "profile a.toml --device interpreter --device 0", 2, &["several --device", "times nothing"]);
}

#[test]
fn the_interpreter_predicts_without_a_device() {
    let here = folder(&[("a.toml", BALL)]);
    let line = "profile a.toml --set object.0.detail=0 --device interpreter --as h100";
    let (out, _) = good(&here, &format!("{line} --by kernel --csv c.csv"));
    for words in ["NVIDIA H100 SXM: predicted", "counted on the interpreter, 128 invocations", "submissions: 1, 20 us"]
    {
        assert!(out.contains(words), "{words}: {out}");
    }
    // A dispatch, a barrier before it, and the widest group.
    assert!(crate::shell::read(&here, "c.csv").contains(",transport/blocks/link/scan,1,1,1024,"), "{out}");
    bad(&here, &format!("{line} --transport walk"), 2, &["--as", "found walk", "another --transport"]);
    bad(&here, &format!("{line} --transport octree"), 2, &["--as", "found octree", "another --transport"]);
    bad(&here, &line.replace("h100", "h200"), 2, &["--as: no such device", "found h200"]);
    #[cfg(feature = "shaderc")]
    {
        let (source, _) = good(&here, "shader transport/blocks/push");
        let own = source.replacen("void main()", "void once()", 1) + "void main() { once(); once(); }\n";
        std::fs::write(here.path().join("own.comp"), own).unwrap();
        let (out, _) = good(&here, &format!("{line} --by kernel --replace transport/blocks/push=own.comp"));
        let told = out.lines().find(|line| line.starts_with("with the built-in kernels: ")).unwrap();
        assert!(told.contains("us; transport/blocks/push ") && !told.contains(','), "{out}");
        let (source, _) = good(&here, "shader transport/diffusion/deposit");
        std::fs::write(here.path().join("deposit.comp"), source).unwrap();
        let unused = format!("{line} --replace transport/diffusion/deposit=deposit.comp");
        bad(&here, &unused, 2, &["--replace", "does not run this kernel"]);
    }
}

#[test]
fn a_case_is_replayed_on_the_interpreter() {
    let here = folder(&[]);
    good(&here, "dump push --fixture sliver --no-validation -o sound");
    let (out, _) = good(&here, "replay sound --device interpreter");
    assert!(out.contains("interpreter, milkglass") && out.contains("passes"), "{out}");
    let (text, _) = good(&here, "shader transport/blocks/push");
    std::fs::write(here.path().join("swap.comp"), text.replace("max(sum, vec3(0))", "max(sum.yxz, vec3(0))")).unwrap();
    let command = "replay sound --device interpreter --replace transport/blocks/push=swap.comp";
    bad(&here, command, 1, &["radiosity[", "1 case fails on this device"]);
    bad(&here, "replay sound --device interpreter --bug bug.md", 2, &["--bug", "a Vulkan device"]);
}

#[test]
fn what_takes_a_device_is_refused() {
    let here = folder(&[("a.toml", BALL)]);
    bad(&here, "conform a.toml --device interpreter --isolate", 2, &["--isolate", "a Vulkan device"]);
    bad(&here, "conform a.toml --sanitize --dump x", 2, &["--dump"]);
    bad(&here, "conform a.toml --sanitize --device 0", 2, &["--device"]);
    bad(&here, "conform a.toml --sanitize --stage links", 2, &["--stage"]);
    bad(&here, "conform a.toml --sanitize --stage relief", 1, &["nothing was watched"]);
}
