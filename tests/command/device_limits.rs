//! Limits that would otherwise give silently wrong results are refused: scenes beyond the range of `f32`, outputs that
//! would overwrite inputs, shaders of unbounded size.

use std::os::unix::fs::symlink;

use crate::shell::{bad, bytes, folder, good, names, program, read, said};

/// A marble ball above a plane of this size.
fn ground(size: f64) -> String {
    format!(
        "[[light]]\ntype = 'directional'\ndirection = [0, 1, 0]\nirradiance = 1\n\
         [[object]]\nshape = 'sphere'\ndetail = 1\nsize = 20\nmaterial = {{ preset = 'marble' }}\n\
         [[object]]\nshape = 'plane'\nsize = {size}\nmaterial = {{ opaque = true, albedo = 0.5 }}\n"
    )
}

#[test]
fn an_object_lost_in_its_scene_is_refused_with_its_line() {
    let text = [("near.toml", &ground(1e3)[..]), ("far.toml", &ground(1e6)[..])];
    let here = folder(&text);
    good(&here, "solve near.toml --device cpu -o a.csv");
    let words = ["far.toml:5: object.0: the object is too small beside the whole scene", "as dense as that"];
    bad(&here, "solve far.toml --device cpu -o b.csv", 2, &words);
    let thin = "--set object.0.material.sigma_s_prime=1e-9 --set object.0.material.sigma_a=0";
    good(&here, &format!("solve far.toml --device cpu {thin} -o c.csv"));
    bad(&here, &format!("solve far.toml --device cpu {thin} --set object.1.size=1e8 -o d.csv"), 2, &["too small"]);
}

#[test]
fn a_fan_that_a_device_does_not_go_round_is_refused_there() {
    let count = 33_000;
    let at = |k: usize| (k as f64 / count as f64 * std::f64::consts::TAU).sin_cos();
    let mut text = String::from("v 0 0 0\n");
    (0..count).for_each(|k| text += &format!("v {} {} 1\n", at(k).0, at(k).1));
    (0..count).for_each(|k| text += &format!("f 1 {} {}\n", k + 2, (k + 1) % count + 2));
    let here = folder(&[("fan.obj", &text)]);
    let line = "render fan.obj --transport lambert --size 4x4 -o a.png --device";
    good(&here, &format!("{line} cpu"));
    if std::env::var_os("MILKGLASS_NO_DEVICE").is_none() {
        let words = ["object.0: too many triangles at one vertex", "found 33000", "`--device cpu` takes more"];
        bad(&here, &format!("{line} 0"), 2, &words);
    }
}

#[test]
fn numbers_beyond_what_a_frame_holds_are_refused() {
    let here = folder(&[("rows.csv", "light,layers,lx,ly,lz,intensity,wox,woy,woz,thickness1,sigma_s1,sigma_t1,g1\n")]);
    let line = "render sphere --device cpu --set camera.size=[64,64] -o a.png --set";
    good(&here, &format!("{line} camera.fov=1e-3"));
    bad(&here, &format!("{line} camera.fov=1e-4"), 2, &["camera.fov: too narrow", "at least 8.7e-4 degrees"]);
    bad(
        &here,
        "render sphere --device cpu --set camera.size=[64,64] --set camera.fov=1e-3 --size 64x999 -o b.png",
        2,
        &["camera.fov: too narrow"],
    );
    let noise = |more: &str| format!("{line} object.0.deform=[{{type='noise',amplitude=0.1,{more}}}]");
    good(&here, &noise("scale=5,offset=[9e4,0,0]"));
    bad(&here, &noise("scale=5,offset=[1e8,0,0]"), 2, &["object.0.deform", "no noise any more"]);
    bad(&here, &noise("scale=1e-5"), 2, &["no noise any more"]);
    let dense = "object.0.material.sigma_s_prime=1e308 --set object.0.material.sigma_a=1e308";
    bad(&here, &format!("{line} {dense}"), 2, &["sigma_s_prime: out of range", "1e308 and 1e308"]);
    let ball = "v 0 0 0\nv 1e-108 0 0\nv 0 1e-108 0\nv 0 0 1e-108\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let here = folder(&[("ball.obj", ball), ("r.csv", "r,sigma_s_prime,sigma_a,eta\n1,1,0,1.3\n1e200,1,0,1.3\n")]);
    bad(&here, "render ball.obj --device cpu -o a.png", 2, &["ball.obj: the mesh is too small", "1e-108 across"]);
    bad(&here, "eval profile r.csv --device cpu -o o.csv", 2, &["r.csv:3: value", "found NaN"]);
}

#[test]
fn no_output_takes_the_place_of_an_input_or_of_another() {
    let scene = ground(40.0);
    let here = folder(&[("mine.toml", &scene), ("rows.csv", "cos_theta,sigma\n0.5,0.1\n")]);
    bad(&here, "plan mine.toml --device cpu --json mine.toml", 2, &["mine.toml", "it was read to make this"]);
    bad(&here, "eval cdrf rows.csv --device cpu -o ./rows.csv", 2, &["rows.csv", "it was read to make this"]);
    bad(&here, "profile sphere --device cpu --csv x --json ./x", 2, &["--json: the same file as --csv"]);
    assert_eq!(read(&here, "mine.toml"), scene);
    // Writing to a symbolic link writes the file that it points to.
    symlink("there.csv", here.path().join("link.csv")).unwrap();
    std::fs::write(here.path().join("there.csv"), "old").unwrap();
    good(&here, "eval cdrf rows.csv --device cpu -o link.csv");
    assert!(here.path().join("link.csv").is_symlink());
    assert!(read(&here, "there.csv").starts_with("cos_theta,sigma,value"));
    // The longest file name is accepted; a longer one is refused.
    let name = format!("{}.csv", "n".repeat(251));
    good(&here, &format!("eval cdrf rows.csv --device cpu -o {name}"));
    bad(&here, &format!("solve sphere --device cpu -o n{name}"), 2, &["could not be written", "too long"]);
}

#[test]
fn a_shader_without_end_is_refused() {
    if std::env::var_os("MILKGLASS_NO_DEVICE").is_some() {
        return;
    }
    let here = folder(&[(
        "me.comp",
        "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"me.comp\"\n",
    )]);
    let line = "conform --only sphere --replace transport/blocks/push=";
    bad(&here, &format!("{line}/dev/zero"), 2, &["/dev/zero: the shader could not be read: not a plain file"]);
    bad(&here, &format!("{line}me.comp"), 2, &["me.comp", "includes more than 256 files"]);
    std::fs::write(here.path().join("long.comp"), vec![b' '; 1 << 21]).unwrap();
    bad(&here, &format!("{line}long.comp"), 2, &["long.comp", "at most 1048576 are read"]);
}

#[test]
fn a_shader_that_is_none_is_refused_in_a_few_lines() {
    if std::env::var_os("MILKGLASS_NO_DEVICE").is_some() {
        return;
    }
    let head = "#version 460\n#extension GL_GOOGLE_include_directive : require\n";
    let here = folder(&[
        ("nul.comp", "#version 460\nvoid main() {\0}\n"),
        ("outer.comp", &format!("{head}#include \"inner.glsl\"\nvoid main() {{}}\n")),
        ("inner.glsl", "// a\0b\n"),
        ("bare.comp", "layout(local_size_x = 64) in;\nvoid main() {}\n"),
        ("wrong.comp", &format!("{head}{}void main() {{}}\n", "fault();\n".repeat(500))),
    ]);
    let line = "conform --only sphere --replace transport/blocks/push=";
    bad(&here, &format!("{line}nul.comp"), 2, &["nul.comp", "line 2 has a NUL byte"]);
    bad(&here, &format!("{line}outer.comp"), 2, &["inner.glsl: line 1 has a NUL byte"]);
    bad(&here, &format!("{line}bare.comp"), 2, &["bare.comp:1: the shader has no #version; expected #version 460"]);
    let said = bad(&here, &format!("{line}wrong.comp"), 2, &["wrong.comp", "wrong.comp:3: error"]);
    assert!(said.lines().count() < 30, "{said}");
}

#[test]
fn names_with_percent_signs_stay_themselves() {
    let here = folder(&[]);
    std::fs::create_dir(here.path().join("100%done")).unwrap();
    let ball = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(here.path().join("100%done/b.obj"), ball).unwrap();
    good(&here, "render 100%done/b.obj --device cpu --size 8x8 -o a.png");
}

#[test]
fn only_whole_frames_of_a_plain_file_are_skipped_or_made() {
    let here = folder(&[("f-0.png", ""), ("s.toml", &ground(40.0))]);
    let line = "--device cpu --size 8x8 --frames 0..1 -o f-%d.png";
    let (_, told) = good(&here, &format!("render sphere {line} --skip-existing"));
    assert!(told.contains("2 frames") && !bytes(&here, "f-0.png").is_empty(), "{told}");
    let (_, told) = good(&here, &format!("render sphere {line} --skip-existing"));
    assert!(told.contains("0 frames, 2 were there"), "{told}");
    let pipe = format!("cat s.toml | \"$0\" render /dev/stdin {line}");
    let mut shell = std::process::Command::new("sh");
    let piped = shell.current_dir(here.path()).args(["-c", &pipe, env!("CARGO_BIN_EXE_milkglass")]).output();
    let (_, err) = said(&piped.unwrap());
    assert!(err.contains("--frames: the scene is read again for every frame"), "{err}");
    assert!(names(here.path()).iter().all(|name| !name.contains("part")));
}

#[test]
fn long_names_times_long_lists_take_no_long_time() {
    let n = 1 << 18;
    let here = folder(&[("a.toml", &format!("{}=[{}]\n", "k".repeat(n), "1,".repeat(n)))]);
    let start = std::time::Instant::now();
    let output = program(&here, "render a.toml --device cpu -o a.png").output().unwrap();
    let (_, err) = said(&output);
    assert!(output.status.code() == Some(2) && err.contains("unknown key") && err.len() < 4000, "{}", err.len());
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn who_leaves_too_little_to_keep_is_told() {
    let here = folder(&[]);
    let line = "render sphere --set object.0.detail=0 --device cpu --size 300x300 --aov -o a.exr";
    let words = ["--limit-memory: keeping lists between frames", "--limit-memory leaves", "do without --aov"];
    bad(&here, &format!("{line} --set transport.receivers=pixels --limit-memory 20M"), 2, &words);
}
