//! `render` of a mesh alone, in its studio, and `gallery`.

use std::fmt::Write as _;
use std::path::Path;

use crate::shell::{bad, bytes, folder, good, names, program, read, said};

/// A box of 4 x 2 x 1, thin along y, as an OBJ file.
fn sheet() -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let at = |k: u32, size: f64| f64::from(corner >> k & 1) * size;
        let _ = writeln!(text, "v {} {} {}", at(0, 4.0), at(1, 2.0), at(2, 0.5));
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    }
    text
}

fn pixels(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_mesh_alone_is_shown_in_a_studio() {
    let here = folder(&[("sheet.obj", &sheet())]);
    let (_, err) = good(&here, "render sheet.obj -o a.png --size 48x48");
    assert!(
        err.contains("sheet: ") && err.contains(" is up (a guess: --up), 20 mm (--size-mm), marble (--preset)"),
        "{err}"
    );
    let picture = pixels(&here.path().join("a.png"));
    // A grey backdrop in the corner, and the object, brighter, in the middle.
    let (corner, middle) = (picture.get_pixel(0, 0).0, picture.get_pixel(24, 24).0);
    assert!(corner.iter().all(|&c| (20..150).contains(&c)), "{corner:?}");
    assert!(middle[0] > corner[0].saturating_add(20), "{corner:?} {middle:?}");

    // Each flag changes the picture.
    let flags = [
        "--preset ketchup",
        "--size-mm 2",
        "--samples 1",
        "--up z",
        "--ground",
        "--set object.0.material.preset=potato",
    ];
    for flag in flags {
        good(&here, &format!("render sheet.obj -o b.png --size 48x48 {flag}"));
        assert!(pixels(&here.path().join("b.png")) != picture, "{flag}");
    }
    let (_, err) = good(&here, "render sheet.obj -o b.png --size 48x48 --size-mm 900");
    assert!(err.contains("looks opaque") && err.contains("--size-mm "), "{err}");

    // `solve` and a scene file keep their own light.
    let (out, _) = good(&here, "plan sheet.obj");
    assert!(out.contains("the material's surface reflects nothing"), "{out}");
}

#[test]
fn the_studio_is_printed_as_a_scene_that_looks_the_same_and_exposed_for_what_it_shows() {
    let here = folder(&[("sheet.obj", &sheet())]);
    let (text, _) = good(&here, "scenes sheet.obj");
    std::fs::write(here.path().join("studio.toml"), &text).unwrap();
    good(&here, "render sheet.obj -o a.png --size 64x64");
    let (_, err) = good(&here, "render studio.toml -o b.png --size 64x64");
    assert!(bytes(&here, "a.png") == bytes(&here, "b.png"), "{text}");
    assert!(text.contains("exposure = \"auto\"") && err.contains(", exposure "), "{err}");
    // The brightest pixels of the object are just below white. It covers the pixels that the backdrop does not change.
    for shade in [0, 1] {
        let flat = format!("camera.background={shade} --set camera.samples=1 --set camera.exposure=1");
        good(&here, &format!("render studio.toml -o {shade}.png --size 64x64 --transport none --set {flat}"));
    }
    let [black, white] = ["0.png", "1.png"].map(|name| pixels(&here.path().join(name)));
    let shown = |name: &str| -> Vec<u8> {
        let all = pixels(&here.path().join(name));
        let seen = all.pixels().zip(black.pixels().zip(white.pixels())).filter(|(_, (black, white))| black == white);
        let mut shown: Vec<u8> = seen.map(|(pixel, _)| *pixel.0.iter().max().unwrap()).collect();
        shown.sort_unstable();
        shown
    };
    let own = shown("a.png");
    let bright = own[own.len() * 98 / 100];
    assert!(own.len() > 200 && (235..=250).contains(&bright), "{bright} of {} pixels", own.len());
    good(&here, "render studio.toml -o c.png --size 64x64 --set camera.exposure=9");
    assert!(shown("c.png").iter().filter(|&&x| x == 255).count() > own.len() / 4, "washed out at 9");
    bad(&here, "render studio.toml -o d.png --set camera.exposure='bright'", 2, &["a number or \"auto\""]);
}

#[test]
fn a_film_has_one_exposure_whatever_part_of_it_is_rendered() {
    let scene = "[camera]\nposition = [0, 0, 60]\nsize = [24, 24]\nexposure = 'auto'\n\
                 [[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\n\
                 irradiance = { keyframes = [[0, 1], [2, 9]] }\n\
                 [[object]]\nshape = 'sphere'\ndetail = 2\nsize = 20\nmaterial = { preset = 'marble' }\n";
    let here = folder(&[("film.toml", scene)]);
    let (_, err) = good(&here, "render film.toml --frames 0..2 -o a%d.png --device cpu");
    assert!(err.contains("in all frames"), "{err}");
    good(&here, "render film.toml --frames 2..2 -o b%d.png --device cpu");
    assert!(bytes(&here, "a2.png") == bytes(&here, "b2.png"));
    // Alone, a picture has its own.
    good(&here, "render film.toml --frame 2 -o c.png --device cpu");
    assert!(bytes(&here, "a2.png") != bytes(&here, "c.png"));
    good(&here, "render film.toml --frame 0 -o c.png --device cpu");
    assert!(bytes(&here, "a0.png") == bytes(&here, "c.png"));
    let below = "render sheet.obj -o d.png --ground --view-from 0,-40";
    std::fs::write(here.path().join("sheet.obj"), sheet()).unwrap();
    bad(&here, below, 2, &["--view-from", "below the table"]);
}

#[test]
fn surroundings_light_a_mesh() {
    let here = folder(&[("sheet.obj", &sheet())]);
    let file = std::fs::File::create(here.path().join("red.hdr")).unwrap();
    let sky: Vec<_> = (0..32).map(|_| image::Rgb([9.0f32, 1.0, 1.0])).collect();
    image::codecs::hdr::HdrEncoder::new(file).encode(&sky, 8, 4).unwrap();
    let (_, err) = good(&here, "render sheet.obj -o a.png --size 32x32 --environment red.hdr");
    assert!(err.contains("the image's light"), "{err}");
    let corner = pixels(&here.path().join("a.png")).get_pixel(0, 0).0;
    assert!(corner[0] > 60 && corner[0] > 2 * corner[1], "{corner:?}");
}

/// Hundredths of a second and sRGB bytes of the frames of a GIF.
fn frames(path: &Path) -> Vec<(u16, Vec<u8>)> {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut film = options.read_info(std::fs::File::open(path).unwrap()).unwrap();
    assert_eq!(film.repeat(), gif::Repeat::Infinite);
    let rgb = |frame: &gif::Frame<'_>| frame.buffer.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
    std::iter::from_fn(|| film.read_next_frame().unwrap().map(|frame| (frame.delay, rgb(frame)))).collect()
}

#[test]
fn a_turntable_goes_round_a_scene() {
    let ball =
        "[[object]]\nshape = 'slab'\ndetail = 2\nposition = [30, 0, 0]\nsize = 9\nmaterial = { preset = 'skin1' }\n";
    let scene = format!(
        "[camera]\nsize = [24, 24]\nbackground = 'none'\n[[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\nirradiance = 3\n{ball}"
    );
    let here = folder(&[("s.toml", &scene)]);
    good(&here, "render s.toml -o t%d.png --turntable 2 --device cpu");
    std::fs::write(here.path().join("t1.png"), "kept").unwrap();
    let (_, told) = good(&here, "render s.toml -o t%d.png --turntable 2 --skip-existing --device cpu");
    assert!(told.contains("0 frames, 2 were there") && bytes(&here, "t1.png") == b"kept", "{told}");
    std::fs::remove_file(here.path().join("t1.png")).unwrap();
    good(&here, "render s.toml -o t%d.png --turntable 2 --skip-existing --device cpu");
    good(&here, "render s.toml -o one.png --device cpu");
    assert!(bytes(&here, "t0.png") == bytes(&here, "one.png"));
    // From behind: in the middle again, without the light of the front.
    let light = |name: &str| pixels(&here.path().join(name)).get_pixel(12, 12).0[0];
    let alpha = |name: &str| image::open(here.path().join(name)).unwrap().into_rgba8().get_pixel(12, 12).0[3];
    assert!(alpha("t0.png") == 255 && alpha("t1.png") == 255);
    assert!(light("t0.png") > light("t1.png") + 30, "{} {}", light("t0.png"), light("t1.png"));

    let run = "render s.toml --turntable 2 --device cpu -o";
    bad(&here, &format!("{run} a.gif"), 2, &["s.toml:3: camera.background: a GIF holds", "found \"none\""]);
    let cases: [(&str, &[&str]); 5] = [
        ("render s.toml -o a.gif", &["found .gif", "with --frames or --turntable"]),
        (
            "render s.toml -o a.gif --frames 0..1 --skip-existing",
            &["--skip-existing: only for frames that have a file each"],
        ),
        ("render s.toml -o a.png --skip-existing", &["--skip-existing: only for frames", "--frames or --turntable"]),
        ("render s.toml -o a-%02d.gif --turntable 2", &["a GIF holds all frames", "found a-%02d.gif", "NAME.gif"]),
        ("render s.toml -o a.gif --frames 0..1 --aov", &["--aov: only OpenEXR has layers"]),
    ];
    for (line, words) in cases {
        bad(&here, line, 2, words);
    }
    good(&here, "render s.toml -o a.gif --frames 0..0 --fps 0.001 --set camera.background=0 --device cpu");
    let film = frames(&here.path().join("a.gif"));
    assert!(film.len() == 1 && film[0].0 == u16::MAX, "a frame of at most 655 seconds");
    let sizes = "camera.size={keyframes=[[0,[8,8]],[1,[9,8]]]}";
    let line = format!("render s.toml -o b.gif --frames 0..1 --device cpu --set camera.background=0 --set {sizes}");
    let words = ["camera.size: the frames of a GIF have one size", "found 9 x 8", "frame 1; nothing was rendered"];
    bad(&here, &line, 2, &words);
    assert!(!names(here.path()).iter().any(|name| name.starts_with("b.") || name.ends_with("part")));
    good(&here, &format!("{line} --size 8x8"));
}

#[test]
fn frames_per_second_of_what_stands_still_are_named() {
    let scene = "fps = 12\n[camera]\nsize = [8, 8]\n[[object]]\nshape = 'slab'\nmaterial = { preset = 'marble' }\n";
    let here = folder(&[("s.toml", scene), ("sheet.obj", &sheet())]);
    let render = |rest: &str| format!("render {rest} --size 8x8 --device cpu");
    let idle = "fps has no effect: the scene has neither an animation nor keyframes";
    for line in ["s.toml -o a.png", "s.toml -o a%d.png --turntable 2"] {
        assert!(good(&here, &render(line)).1.contains(idle), "{line}");
    }
    assert!(!good(&here, &render("s.toml -o a.gif --turntable 2 --fps 9")).1.contains("fps"));
    good(&here, &render("s.toml -o a.png --fps 9 --set camera.fov={keyframes=[[0,40],[1,50]]}"));
    for line in ["s.toml -o b.png --fps 9", "sheet.obj -o b.png --fps 9", "s.toml -o b%d.png --turntable 2 --set fps=9"]
    {
        bad(
            &here,
            &render(line),
            2,
            &["fps", "has no effect", "found 9; expected an `animation`, keyframes, or a GIF"],
        );
    }
    bad(&here, "plan sphere --fps 9 --device cpu", 2, &["fps", "has no effect"]);
}

#[test]
fn a_lens_too_wide_for_its_focus_is_an_error() {
    let here = folder(&[("sheet.obj", &sheet())]);
    let render = |rest: &str| format!("render sheet.obj --size 8x8 --samples 2 --device cpu {rest}");
    good(&here, &render("-o a.png"));
    good(&here, &render("-o b.png --set camera.focus=1e-9"));
    assert!(bytes(&here, "a.png") == bytes(&here, "b.png"), "a pinhole has no focus");
    bad(&here, &render("-o c.png --set camera.focus=1e-320"), 2, &["camera.focus", "expected 1e-9 to 1e9"]);
    let wide = "-o c.png --set camera.focus=1e-9 --set camera.aperture=1";
    bad(&here, &render(wide), 2, &["camera.aperture", "too wide a lens", "found 1; expected at most"]);
}

#[test]
fn a_turntable_goes_round() {
    let here = folder(&[("sheet.obj", &sheet())]);
    good(&here, "render sheet.obj -o t-%02d.png --size 32x32 --samples 2 --turntable 4");
    assert_eq!(names(here.path()), ["sheet.obj", "t-00.png", "t-01.png", "t-02.png", "t-03.png"]);
    good(&here, "render sheet.obj -o one.png --size 32x32 --samples 2");
    let at = |name: &str| pixels(&here.path().join(name));
    // One film of them all, with each one's size, colours and time.
    good(&here, "render sheet.obj -o t.gif --size 32x32 --samples 2 --turntable 4 --fps 8");
    let film = frames(&here.path().join("t.gif"));
    assert_eq!(film.iter().map(|(delay, _)| delay).sum::<u16>(), 50);
    for (number, (_, pixels)) in film.iter().enumerate() {
        let still = at(&format!("t-{number:02}.png")).into_raw();
        let off: u32 = still.iter().zip(pixels).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        assert!(pixels.len() == still.len() && off < 4 * still.len() as u32, "frame {number}: {off}");
    }
    assert!(at("t-00.png") == at("one.png") && at("t-01.png") != at("t-00.png") && at("t-02.png") != at("t-00.png"));
}

#[test]
fn wrong_flags_are_named() {
    let here = folder(&[
        ("sheet.obj", &sheet()),
        ("s.toml", "[[object]]\nshape = 'slab'\nmaterial = { preset = 'marble' }\n"),
    ]);
    let cases = [
        ("render sheet.obj -o a.png --preset marbel", ["--preset", "did you mean `Marble`?"]),
        ("render sheet.obj -o a.png --size-mm 0", ["--size-mm: not a size", "expected"]),
        ("render sheet.obj -o a.png --size-mm 5 --set object.0.size=4", ["--size-mm", "a second time"]),
        ("render sheet.obj -o a.png --samples 65", ["--samples", "1..=64"]),
        ("render sheet.obj -o a.png --up x", ["--up", "[possible values: y, z]"]),
        ("render sheet.obj -o a.png --environment sky.png", ["--environment", ".exr or .hdr"]),
        ("render sheet.obj -o a.png --turntable 4", ["own", "frame-%04d.png"]),
        ("render lotus -o a.png --preset marble", ["--preset: only for a mesh alone", "object.0.material.preset"]),
        ("render s.toml -o a.png --ground", ["--ground: only for a mesh alone", "plane"]),
        ("gallery s.toml -o g", ["not a mesh alone", "s.toml"]),
        ("gallery -o g --materials marbel", ["unknown preset", "did you mean `Marble`?"]),
    ];
    for (line, words) in cases {
        bad(&here, line, 2, &words);
    }
    // With a scene, --samples is the camera's.
    good(&here, "render s.toml -o a.png --size 16x16 --samples 4");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_gallery_repeats_itself() {
    let grey = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n@@@\u{7f}@@@\u{7f}";
    let here = folder(&[("sheet.obj", &sheet()), ("grey.hdr", grey)]);
    let environments = "--environments studio,grey.hdr";
    good(&here, &format!("gallery sheet.obj -o g --materials skin1,marble {environments} --size 24x24 --samples 2"));
    // A gallery replaces an earlier one.
    good(&here, &format!("gallery sheet.obj -o g --materials skin1,marble {environments} --size 24x24 --samples 2"));
    for (words, told) in [
        ("--environments studio,studio", ["--environments: is there twice", "found `studio`"]),
        ("--environments studio,", ["--environments: not an environment", "found ``"]),
        ("--environments studio,none.hdr", ["--environments: not an environment", "found `none.hdr`"]),
        ("--materials Marble,marble", ["--materials: is there twice", "found `marble`"]),
        ("--materials marble,", ["--materials: unknown preset", "found ;"]),
        ("bust", ["FILE: not a mesh alone", "found bust"]),
    ] {
        let err = bad(&here, &format!("gallery sheet.obj -o new --size 8x8 --samples 1 {words}"), 2, &told);
        assert!(!err.contains("1/") && !here.path().join("new").exists(), "{err}");
    }
    let stems = ["sheet-0-skin1", "sheet-0-marble", "sheet-0-skin1-in-1", "sheet-0-marble-in-1"];
    let pictures = stems.map(|stem| format!("{stem}.png"));
    let mut all = [&["index.html".to_owned(), "sheet.png".to_owned()], &pictures[..]].concat();
    all.sort();
    assert_eq!(names(&here.path().join("g")), all);
    let page = read(&here, "g/index.html");
    let commands: Vec<&str> =
        page.split("<code>milkglass ").skip(1).filter_map(|part| part.split('<').next()).collect();
    assert!(commands.len() == 4 && page.matches(" s<br>").count() == 4, "{page}");
    let of_sheet = pixels(&here.path().join("g/sheet.png")).into_raw();
    for (number, (command, picture)) in commands.iter().zip(pictures).enumerate() {
        good(&here, command);
        let alone = pixels(&here.path().join(&picture));
        assert!(alone == pixels(&here.path().join("g").join(picture)), "{command}");
        // On the sheet each has its place: of 2 in a row, 24 x 24.
        for (y, line) in alone.chunks(3 * 24).enumerate() {
            let start = 3 * (48 * (24 * (number / 2) + y) + 24 * (number % 2));
            assert!(of_sheet[start..][..3 * 24] == *line, "{command}: row {y} of the sheet");
        }
    }

    // Built-in shapes come with scene files.
    let local = "--transport lambert";
    good(&here, &format!("gallery -o shapes --materials marble {environments} --size 16x16 --samples 1 {local}"));
    let shapes = folder(&[]);
    for stem in ["torus-marble", "torus-marble-in-1"] {
        let scene = here.path().join(format!("shapes/{stem}.toml"));
        let output = program(&shapes, &format!("render {} {local} -o t.png", scene.display())).output().unwrap();
        assert!(output.status.success(), "{:?}", said(&output));
        let command = format!("milkglass render {stem}.toml {local} -o {stem}.png");
        assert!(read(&here, "shapes/index.html").contains(&command), "{command}");
        assert!(pixels(&shapes.path().join("t.png")) == pixels(&here.path().join(format!("shapes/{stem}.png"))));
    }
}
