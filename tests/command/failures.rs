//! Failures of the environment: full disks, closed pipes, Ctrl-C, missing Vulkan drivers.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::shell::{self, bad, folder, good, names, program, said};

const SMALL: &str = "sphere --set object.0.detail=1 --size 64x48";

/// Runs a shell command in this folder, with `$0` as the program.
fn sh(folder: &tempfile::TempDir, line: &str) -> Output {
    let mut command = Command::new("sh");
    command.current_dir(folder.path()).args(["-c", line, env!("CARGO_BIN_EXE_milkglass")]);
    command.env("MILKGLASS_VALIDATION", "0").output().unwrap()
}

/// Checks the exit code, that there was no panic, and that one line of standard error contains all these words.
fn ended(output: &Output, code: i32, words: &[&str]) {
    let (out, err) = said(output);
    assert_eq!(output.status.code(), Some(code), "{out}{err}");
    assert!(!err.contains("panicked"), "{err}");
    let line = err.lines().find(|line| words.iter().all(|word| line.contains(word)));
    assert!(words.is_empty() || line.is_some(), "no line with {words:?} in {err}");
}

/// A pipe without a writer: the program says what it waits for, and Ctrl-C ends it.
#[test]
fn a_pipe_is_waited_for_until_it_is_stopped() {
    let here = folder(&[]);
    let line = "mkfifo p.toml; timeout --signal=INT 1 \"$0\" plan p.toml --device cpu";
    let output = sh(&here, line);
    let (_, err) = said(&output);
    assert!(err.contains("p.toml: a pipe; waiting until its writer closes it"), "{err}");
    let line = "(echo '[[object]]'; echo \"shape = 'sphere'\"; echo \"material = { preset = 'marble' }\") > p.toml & \
                \"$0\" plan p.toml --device cpu";
    ended(&sh(&here, line), 0, &["a pipe"]);
}

#[test]
fn a_full_disk_is_an_error_and_leaves_nothing() {
    let here = folder(&[]);
    // `ulimit -f 1` limits files to one block of 512 bytes.
    for file in ["a.png", "a.exr"] {
        let output = sh(
            &here,
            &format!(
                "ulimit -f 1; exec \"$0\" render sphere --set object.0.detail=1 --size 128x96 --device cpu -o {file}"
            ),
        );
        ended(&output, 2, &["milkglass: ", file, "could not be written"]);
        assert!(names(here.path()).is_empty(), "{:?}", names(here.path()));
    }
    let output = sh(&here, "ulimit -f 1; exec \"$0\" solve sphere --set object.0.detail=2 --device cpu -o a.csv");
    ended(&output, 2, &["a.csv", "could not be written"]);
    assert!(names(here.path()).is_empty());
    // An earlier file stays as it was.
    std::fs::write(here.path().join("a.csv"), "old").unwrap();
    sh(&here, "ulimit -f 1; exec \"$0\" solve sphere --set object.0.detail=2 --device cpu -o a.csv");
    assert_eq!(shell::read(&here, "a.csv"), "old");
    if Path::new("/dev/full").exists() {
        ended(&sh(&here, "\"$0\" materials > /dev/full"), 2, &["standard output could not be written"]);
        ended(&sh(&here, "\"$0\" plan sphere --device cpu --json /dev/full"), 2, &["/dev/full", "written"]);
        assert!(!Path::new("/dev/full").metadata().unwrap().is_file());
    }
}

#[test]
fn a_folder_that_takes_no_files_is_named() {
    let here = folder(&[]);
    let rest = format!("{SMALL} --device cpu");
    bad(&here, &format!("render {rest} -o no/such/a.png"), 2, &["no/such/a.png", "could not be written"]);
    std::fs::create_dir(here.path().join("a.png")).unwrap();
    bad(&here, &format!("render {rest} -o a.png"), 2, &["a.png", "it is a folder"]);
    if Path::new("/proc/self").exists() {
        // Nobody can write there, not even root.
        bad(&here, &format!("render {rest} -o /proc/a.png"), 2, &["/proc/a.png", "could not be written"]);
    }
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let here = folder(&[]);
    for line in ["devices", "materials", "scenes", "plan sphere --device cpu", "shader --help", "--version"] {
        let mut child = program(&here, line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut err = String::new();
        child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        assert_eq!((child.wait().unwrap().code(), err.contains("panicked")), (Some(0), false), "{line}: {err}");
    }
    // The same with standard error closed: the picture is still written, and a fault keeps its exit code.
    for (line, code) in [(format!("render {SMALL} --device cpu -o a.png"), 0), ("render none -o a.png".into(), 2)] {
        let mut child = program(&here, &line).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{line}");
    }
    assert_eq!(names(here.path()), ["a.png"]);
}

/// An interrupted sequence leaves whole frames and nothing else, and resumes where it stopped.
#[cfg(unix)]
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn ctrl_c_leaves_whole_frames() {
    let here = folder(&[]);
    let line = "render noise --set object.0.detail=2 --size 16x12 --frames 0..1999 -o f%05d.exr --device cpu";
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129), ("INT", 130)] {
        let before = names(here.path()).len();
        let mut child = program(&here, &format!("{line} --skip-existing")).stderr(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while names(here.path()).len() < before + 5 {
            assert!(start.elapsed() < Duration::from_secs(120) && child.try_wait().unwrap().is_none(), "{signal}");
            std::thread::sleep(Duration::from_millis(5));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-s", signal, &id]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        let there = names(here.path());
        for (k, name) in there.iter().enumerate() {
            assert_eq!(*name, format!("f{k:05}.exr"), "{there:?}");
            exr::prelude::read_all_flat_layers_from_file(here.path().join(name)).unwrap();
        }
    }
}

/// Runs the program with these drivers as the only ones that the loader finds.
fn with_drivers(folder: &tempfile::TempDir, line: &str, drivers: &str) -> Output {
    program(folder, line).env("VK_DRIVER_FILES", drivers).env("VK_ICD_FILENAMES", drivers).output().unwrap()
}

/// Missing drivers are reported in one line with a remedy; without `--device` the program runs on the CPU.
#[test]
fn without_drivers_the_cpu_runs_and_says_so() {
    let here = folder(&[
        ("broken.json", "{ \"file_format_version\": "),
        ("hollow.json", "{}"),
        (
            "gone.json",
            "{\"file_format_version\": \"1.0.0\", \"ICD\": {\"library_path\": \"/no/such/library.so\", \"api_version\": \"1.3.0\"}}",
        ),
    ]);
    if std::env::var_os("MILKGLASS_NO_DEVICE").is_some()
        && !said(&program(&here, "devices").output().unwrap()).1.is_empty()
    {
        println!("WAIVED by MILKGLASS_NO_DEVICE: no loader");
        return;
    }
    for drivers in ["/no/such/file.json", "broken.json", "hollow.json", "gone.json", "."] {
        let drivers = here.path().join(drivers).display().to_string();
        let output = with_drivers(&here, &format!("render {SMALL} -o a.png"), &drivers);
        ended(&output, 0, &["running on the CPU", "no installed driver", "VK_DRIVER_FILES"]);
        let output = with_drivers(&here, &format!("render {SMALL} -o b.png --device 0"), &drivers);
        ended(&output, 3, &["milkglass: ", "no installed driver", "--device cpu"]);
        let output = with_drivers(&here, "devices", &drivers);
        ended(&output, 0, &["no installed driver"]);
        assert!(said(&output).0.contains("CPU reference"));
        ended(&with_drivers(&here, "conform", &drivers), 3, &["no installed driver"]);
    }
    assert!(names(here.path()).contains(&"a.png".to_string()) && !names(here.path()).contains(&"b.png".to_string()));
}

/// A requested validation layer that is not installed is an error.
#[test]
fn a_missing_validation_layer_is_said() {
    let here = folder(&[("none.json", "{}")]);
    let line = format!("render {SMALL} -o a.png");
    let mut command = program(&here, &line);
    let layers = ["VK_LAYER_PATH", "VK_ADD_LAYER_PATH"].map(|name| (name, here.path()));
    command.envs(layers).env("MILKGLASS_VALIDATION", "1");
    let output = command.output().unwrap();
    if std::env::var_os("MILKGLASS_NO_DEVICE").is_none() {
        ended(&output, 3, &["milkglass: ", "validation layer is not installed", "MILKGLASS_VALIDATION"]);
        assert_eq!(names(here.path()), ["none.json"]);
    }
}

#[test]
fn a_time_out_is_a_number() {
    let here = folder(&[]);
    for value in ["soon", "0", "-1", "nan", "1e9"] {
        let output = program(&here, "render sphere -o a.png").env("MILKGLASS_TIMEOUT", value).output().unwrap();
        if !said(&output).1.contains("running on the CPU") {
            ended(&output, 2, &["MILKGLASS_TIMEOUT", value, "seconds"]);
        }
    }
}

/// A user's shader that does not finish in time does not hang the program.
#[test]
fn a_shader_that_hangs_is_left() {
    let here = folder(&[]);
    let (code, _) = good(&here, "shader lighting/irradiance");
    let start = code.find("void main() {").expect("a shader has a beginning") + "void main() {".len();
    let hangs = "float x = 0.0; for (uint i = 0; i < 60000; ++i) x = exp(-0.5 * x) + 0.01 * float(i & 3u); if (x > 9.0) return;";
    std::fs::write(here.path().join("hang.comp"), format!("{}{hangs}{}", &code[..start], &code[start..])).unwrap();
    let scene = "sphere --set object.0.detail=4 --set camera.size=[64,48]";
    let mut command = program(&here, &format!("profile {scene} --replace lighting/irradiance=hang.comp"));
    let begin = Instant::now();
    let output = command.env("MILKGLASS_TIMEOUT", "0.02").output().unwrap();
    if said(&output).1.contains("running on the CPU") {
        return;
    }
    ended(&output, 3, &["has not finished in time", "MILKGLASS_TIMEOUT"]);
    assert!(begin.elapsed() < Duration::from_secs(60), "{:?}", begin.elapsed());
}
