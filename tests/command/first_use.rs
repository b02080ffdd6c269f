//! First frames: on llvmpipe with an empty cache on disk, a filled one, and none; and small ones before large ones.

use crate::shell::{bytes, folder, good, program, said};

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn new_kernels_are_compiled_ahead() {
    let here = folder(&[]);
    let cache = tempfile::tempdir().unwrap();
    let render = |line: &str, extra: Option<(&str, &str)>| {
        let mut command = program(&here, &format!("{line} sphere --set object.0.detail=2"));
        let output = command.env("MESA_SHADER_CACHE_DIR", cache.path()).envs(extra).output().unwrap();
        let (out, err) = said(&output);
        assert!(output.status.success(), "{out}{err}");
        (out.clone(), out.contains("compiling kernels"), err.contains("llvmpipe"))
    };
    let (out, ahead, llvmpipe) = render("render -o first.png --size 64x48 --times", None);
    let several = std::thread::available_parallelism().is_ok_and(|cores| cores.get() > 1);
    assert_eq!(ahead, llvmpipe && several, "{out}");
    render("render -o again.png --size 64x48 --times", None);
    assert_eq!(bytes(&here, "first.png"), bytes(&here, "again.png"));
    // Without a cache nothing is compiled ahead.
    let (out, ahead, _) =
        render("render -o none.png --size 64x48 --times", Some(("MESA_SHADER_CACHE_DISABLE", "true")));
    assert!(!ahead && bytes(&here, "first.png") == bytes(&here, "none.png"), "{out}");
}

#[test]
fn a_small_picture_before_a_large_one_finds_the_light_of_both() {
    let here = folder(&[]);
    let line = "render sphere -o a.png --size 600x600 --times --set object.0.detail=5 --set camera.samples=3";
    let (out, _) = good(&here, line);
    let steps =
        |stage: &str| out.lines().find(|row| row.starts_with(stage)).and_then(|row| row.split_whitespace().nth(1));
    // A small frame and three samples. The ball's 20,480 triangles are more than the small picture's pixels.
    assert_eq!(
        (steps("visibility "), steps("irradiance "), steps("pixel_receivers ")),
        (Some("4"), Some("1"), None),
        "{out}"
    );
}
