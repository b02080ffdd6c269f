//! The command `view` under an X server without a screen. Debian: xvfb, xauth, xdotool; weston for Wayland.

mod controls;
mod long;
mod wayland;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// The program.
const PROGRAM: &str = env!("CARGO_BIN_EXE_milkglass");
/// How long a window may stay open.
const PATIENCE: Duration = Duration::from_secs(120);

/// Starts a command in a folder, under an X server of its own, with the validation layer.
fn under_x(folder: &Path, command: &mut Command) -> Child {
    // Servers that look for a free number at the same time find the same one.
    static SERVERS: AtomicU32 = AtomicU32::new(0);
    let number = 100 + 50 * (std::process::id() % 1000) + SERVERS.fetch_add(1, Ordering::Relaxed);
    let mut all = Command::new("timeout");
    all.arg(PATIENCE.as_secs().to_string()).arg("xvfb-run").arg("-n").arg(number.to_string());
    all.args(["-s", "-screen 0 1280x1024x24"]).arg(command.get_program()).args(command.get_args());
    all.current_dir(folder).env("MILKGLASS_VALIDATION", "1").env_remove("WAYLAND_DISPLAY");
    let child = all.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    child.unwrap_or_else(|error| panic!("xvfb-run: {error}; install xvfb and xauth"))
}

/// Opens a window that plays these events; it must close without an error.
fn view(folder: &Path, arguments: &[&str], events: &str) -> Output {
    let out = opened(folder, arguments, events).wait_with_output().unwrap();
    good(&out);
    out
}

fn opened(folder: &Path, arguments: &[&str], events: &str) -> Child {
    write_events(folder, events);
    under_x(folder, Command::new(PROGRAM).arg("view").args(arguments).args(["--play", "events.toml"]))
}

/// The events of a window that shows no handles over its picture.
fn write_events(folder: &Path, events: &str) {
    std::fs::write(folder.join("events.toml"), format!("event = [{{ key = 'h' }}, {events}]")).unwrap();
}

fn good(out: &Output) {
    assert!(out.status.success(), "{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
}

/// Width, height and the bytes of a picture.
type Pixels = (u32, u32, Vec<u8>);

fn read(file: PathBuf) -> Pixels {
    let picture = image::open(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display())).to_rgb8();
    (picture.width(), picture.height(), picture.into_raw())
}

/// The upper left part of a screenshot: what is not the panel.
fn part((width, _, bytes): &Pixels, [wide, tall]: [u32; 2]) -> Pixels {
    let row = |y: u32| bytes[(y * width * 3) as usize..][..(wide * 3) as usize].to_vec();
    (wide, tall, (0..tall).flat_map(row).collect())
}

/// The picture that `render` writes.
fn rendered(folder: &Path, arguments: &[&str]) -> Pixels {
    let file = folder.join("rendered.png");
    let done = Command::new(PROGRAM).arg("render").args(arguments).arg("-o").arg(&file).current_dir(folder).output();
    good(&done.unwrap());
    read(file)
}

/// Runs the command that the window printed last, which writes `slab` with some ending.
fn repeat(folder: &Path, out: &Output) {
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let command = text.lines().rfind(|line| line.starts_with("milkglass render ")).expect("a command");
    let command = command.replacen("milkglass", PROGRAM, 1);
    good(&Command::new("sh").args(["-c", &command]).current_dir(folder).output().unwrap());
}

/// The picture of that command.
fn repeated(folder: &Path, out: &Output) -> Pixels {
    repeat(folder, out);
    read(folder.join("slab.png"))
}

const SMALL: [&str; 4] = ["slab", "--size=200x150", "--set", "camera.samples=3"];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_window_shows_the_picture_of_render() {
    let folder = tempfile::tempdir().unwrap();
    for present in ["fifo", "mailbox"] {
        let events = "{ whole = true }, { screenshot = 'whole.png' }, { close = true }";
        view(folder.path(), &[&SMALL[..], &["--present", present]].concat(), events);
        let shown = read(folder.path().join("whole.png"));
        assert_eq!(shown.1, 150);
        assert!(part(&shown, [200, 150]) == rendered(folder.path(), &SMALL), "{present}: not the picture of render");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_was_changed_is_what_the_printed_command_renders() {
    let folder = tempfile::tempdir().unwrap();
    let one = |events: &str, changed: &str| {
        let events =
            format!("{events}, {{ whole = true }}, {{ key = 'c' }}, {{ screenshot = 'a.png' }}, {{ key = 'q' }}");
        let out = view(folder.path(), &SMALL, &events);
        assert!(String::from_utf8_lossy(&out.stdout).contains(changed), "{changed}");
        let shown = part(&read(folder.path().join("a.png")), [200, 150]);
        assert!(shown == repeated(folder.path(), &out), "{changed}: not the picture of the command");
        shown
    };
    let plain = rendered(folder.path(), &SMALL);
    let changes = [
        ("{ drag = { from = [50, 50], to = [90, 70] } }", "camera.position"),
        ("{ drag = { button = 'middle', from = [50, 50], to = [90, 70] } }", "camera.target"),
        ("{ wheel = -3.0 }, { key = 'left' }", "camera.position"),
        ("{ drag = { button = 'right', from = [50, 50], to = [150, 70] } }", "light.0."),
        ("{ key = 'm' }, { key = ']' }", "object.0.material.scale"),
        ("{ key = '.' }, { key = '.' }, { key = '.' }, { key = '.' }", "transport.tolerance"),
        ("{ key = 't' }, { key = 't' }", "--transport brute"),
        ("{ set = 'camera.exposure=2' }", "camera.exposure"),
    ];
    for (events, changed) in changes {
        assert!(one(events, changed) != plain, "{changed}: nothing changed");
    }
    // Changes that are taken back.
    let turned = "{ drag = { from = [50, 50], to = [90, 70] } }, { key = 'm' }";
    assert!(one(&format!("{turned}, {{ key = 'u' }}, {{ key = 'u' }}"), "render") == plain, "undo");
    assert!(one(&format!("{turned}, {{ key = 'r' }}"), "render") == plain, "reset");
    assert!(one(&format!("{turned}, {{ key = 'u' }}, {{ key = 'U' }}"), "preset") != plain, "redo");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_window_may_change_its_size_again_and_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut events: Vec<String> =
        (0..20).map(|k| format!("{{ resize = [{}, {}] }}", 300 + 37 * (k % 5), 100 + 53 * (k % 7))).collect();
    events.push("{ resize = [1, 1] }, { frames = 3 }, { resize = [500, 180] }, { whole = true }".into());
    events.push("{ screenshot = 'a.png' }, { close = true }".into());
    view(folder.path(), &SMALL, &events.join(", "));
    let shown = read(folder.path().join("a.png"));
    assert_eq!((shown.0, shown.1), (500, 180));
    let size = ["slab", "--size=230x180", "--set", "camera.samples=3"];
    assert!(part(&shown, [230, 180]) == rendered(folder.path(), &size), "not the picture of render");
}

/// Waits until a file is there and whole.
fn wait_for(file: &Path) -> Pixels {
    let end = Instant::now() + PATIENCE;
    while !file.exists() {
        assert!(Instant::now() < end, "{} does not come", file.display());
        std::thread::sleep(Duration::from_millis(20));
    }
    read(file.to_path_buf())
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_changed_file_is_shown_and_a_mistake_leaves_the_last_good_state() {
    let folder = tempfile::tempdir().unwrap();
    let printed = Command::new(PROGRAM).args(["scenes", "slab"]).output().unwrap();
    let text = String::from_utf8(printed.stdout).unwrap();
    let scene = folder.path().join("mine.toml");
    std::fs::write(&scene, &text).unwrap();
    let arguments = ["mine.toml", "--size=200x150"];
    let events = "{ whole = true }, { screenshot = 'a.png' }, { message = true }, { frames = 30 }, { whole = true }, \
                  { screenshot = 'b.png' }, { message = false }, { whole = true }, { screenshot = 'c.png' }, \
                  { close = true }";
    let child = opened(folder.path(), &arguments, events);
    let first = wait_for(&folder.path().join("a.png"));
    std::fs::write(&scene, text.replace("[camera]", "[camera]\nfow = 3")).unwrap();
    let mistake = wait_for(&folder.path().join("b.png"));
    std::fs::write(&scene, text.replace("exposure = 1.0", "exposure = 3.0")).unwrap();
    good(&child.wait_with_output().unwrap());
    let [first, mistake] = [first, mistake].map(|shown| part(&shown, [200, 150]));
    assert!(first != mistake, "the message is not shown");
    let lower = |(wide, _, bytes): &Pixels| bytes[(wide * 3 * 120) as usize..].to_vec();
    assert!(lower(&first) == lower(&mistake), "the picture behind the message is another one");
    let last = part(&read(folder.path().join("c.png")), [200, 150]);
    assert!(last != first && last == rendered(folder.path(), &arguments), "not the picture of the new file");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_real_mouse_and_real_keys_are_heard() {
    let folder = tempfile::tempdir().unwrap();
    let script = format!(
        "{PROGRAM} view {} --screenshot end.png & \
         id=$(xdotool search --sync --name milkglass); sleep 2; xdotool windowfocus $id; \
         xdotool mousemove 60 60 mousedown 1 mousemove 100 80 mouseup 1; \
         xdotool mousemove 60 60 mousedown 3 mousemove 160 60 mouseup 3; sleep 1; \
         xdotool key m key bracketright key c key question; sleep 1; xdotool key q; wait $!",
        SMALL.join(" ")
    );
    let out = under_x(folder.path(), Command::new("sh").args(["-c", &script])).wait_with_output().unwrap();
    good(&out);
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    for set in ["camera.position", "light.0.", "object.0.material.preset", "object.0.material.scale"] {
        assert!(text.contains(set), "{set}: {text}{}", String::from_utf8_lossy(&out.stderr));
    }
    assert_eq!(read(folder.path().join("end.png")).1, 150);
}

#[test]
fn a_window_closes_after_so_many_frames() {
    let folder = tempfile::tempdir().unwrap();
    let limit = ["view", "slab", "--size=200x150", "--frames-limit=5", "--screenshot=a.png"];
    let out = under_x(folder.path(), Command::new(PROGRAM).args(limit)).wait_with_output().unwrap();
    good(&out);
    assert!(String::from_utf8_lossy(&out.stderr).contains("5 frames"));
    assert_eq!(read(folder.path().join("a.png")).1, 150);
}

#[test]
fn without_a_display_there_is_one_line() {
    for display in [None, Some(":9999")] {
        let mut command = Command::new(PROGRAM);
        command.args(["view", "slab"]).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        let out = command.envs(display.map(|display| ("DISPLAY", display))).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!((out.status.code(), text.lines().count()), (Some(3), 1), "{text}");
        assert!(text.starts_with("milkglass: opening a window: there is no display"), "{text}");
    }
}

#[test]
fn bad_arguments_are_told_before_a_window_opens() {
    let cases: [(&[&str], &str); 4] = [
        (&["--screenshot", "a.exr"], "--screenshot: a screenshot has 8 bits a channel"),
        (&["--device", "cpu"], "--device: a window shows what a Vulkan device renders"),
        (&["--play", "none.toml"], "none.toml: --play: can't be read"),
        (&["--size", "0x5"], "--size: not a picture size"),
    ];
    for (arguments, words) in cases {
        let out = Command::new(PROGRAM).args(["view", "slab"]).args(arguments).env_remove("DISPLAY").output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && text.contains(words), "{text}");
    }
}
