//! What takes long: many edits, and a window that is closed while a frame is rendered.

use super::*;

/// Resident memory of a process in bytes.
fn resident(process: u32) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap();
    text.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_thousand_edits_leave_memory_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let keys = ["m", "left", "]", "ctrl+up", "w", ">", "alt+left", ".", "u", "U", ",", "v", "V", "[", "M", "y", "r"];
    let edits = |count: usize| -> Vec<String> {
        keys.iter().cycle().take(count).map(|key| format!("{{ key = '{key}' }}")).collect()
    };
    let pause = |name: &str| format!("{{ whole = true }}, {{ screenshot = '{name}' }}, {{ frames = 20 }}");
    let parts =
        [edits(300).join(", "), pause("a.png"), edits(700).join(", "), pause("b.png"), "{ close = true }".into()];
    write_events(folder.path(), &parts.join(", "));
    let scene = "slab --size=60x40 --set object.0.detail=4 --set camera.samples=1 --play events.toml";
    let script = format!("{PROGRAM} view {scene} & echo $! > process; wait $!");
    let child = under_x(folder.path(), Command::new("sh").args(["-c", &script]));
    let memory = |name: &str| {
        wait_for(&folder.path().join(name));
        resident(std::fs::read_to_string(folder.path().join("process")).unwrap().trim().parse().unwrap())
    };
    let (before, after) = (memory("a.png"), memory("b.png"));
    let out = child.wait_with_output().unwrap();
    good(&out);
    let mega = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    println!("{:.1} MiB after 300 edits, {:.1} after 1,000", mega(before), mega(after));
    assert!(after < before + (24 << 20), "{:.1} MiB more after 700 more edits", mega(after - before));
    // A message of the validation layer is an error.
    assert!(!String::from_utf8_lossy(&out.stderr).contains("validation"), "{}", String::from_utf8_lossy(&out.stderr));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_window_may_be_closed_while_a_frame_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    // The frame takes seconds: the key comes in the middle of it.
    let script = format!(
        "{PROGRAM} view sphere --transport brute --size=300x200 & \
         id=$(xdotool search --sync --name milkglass); sleep 1; xdotool windowfocus $id; xdotool key q; wait $!"
    );
    good(&under_x(folder.path(), Command::new("sh").args(["-c", &script])).wait_with_output().unwrap());
    // The server that shows the window goes away: an error in one line, and no crash.
    let script = format!(
        "{PROGRAM} view slab --size=200x150 & id=$(xdotool search --sync --name milkglass); sleep 1; \
         xdotool windowkill $id; wait $!"
    );
    let out = under_x(folder.path(), Command::new("sh").args(["-c", &script])).wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(!text.contains("panicked"), "{text}");
    // Neither a signal nor the limit of time.
    assert!(out.status.code().is_some_and(|code| code < 124), "{:?}: {text}", out.status);
}
