//! The same window under Wayland, by weston without a screen.

use super::*;

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_window_under_wayland_shows_the_picture_of_render() {
    if Command::new("weston").arg("--version").output().is_err() {
        println!("NOT TESTED under Wayland: weston is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let here = |command: &mut Command| {
        command.current_dir(folder.path()).env("XDG_RUNTIME_DIR", folder.path()).env_remove("DISPLAY");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let mut weston = here(Command::new("weston").args([
        "--backend=headless-backend.so",
        "--socket=milkglass",
        "--width=1280",
        "--height=1024",
        "--idle-time=0",
    ]));
    let end = Instant::now() + PATIENCE;
    while !folder.path().join("milkglass").exists() {
        assert!(Instant::now() < end, "weston does not start");
        std::thread::sleep(Duration::from_millis(20));
    }
    let events = "{ whole = true }, { key = 'c' }, { screenshot = 'whole.png' }, { close = true }";
    write_events(folder.path(), events);
    let mut command = Command::new("timeout");
    command.arg(PATIENCE.as_secs().to_string()).arg(PROGRAM).arg("view").args(SMALL).args(["--play", "events.toml"]);
    let out = here(command.env("WAYLAND_DISPLAY", "milkglass").env("MILKGLASS_VALIDATION", "1")).wait_with_output();
    weston.kill().unwrap();
    weston.wait().unwrap();
    good(&out.unwrap());
    let shown = part(&read(folder.path().join("whole.png")), [200, 150]);
    assert!(shown == rendered(folder.path(), &SMALL), "not the picture of render");
}
