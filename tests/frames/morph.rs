//! Morphs between meshes of equal topology.

use crate::shell::{bad, bytes, folder, good, numbers, read};
use tempfile::TempDir;

/// An OBJ file: a pyramid over a square of this side, with its apex at `top`.
fn pyramid(side: f64, top: [f64; 3]) -> String {
    let [x, y, z] = top;
    let s = side;
    format!(
        "v 0 0 0\nv {s} 0 0\nv {s} {s} 0\nv 0 {s} 0\nv {x} {y} {z}\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
    )
}

const SCENE: &str = "[camera]\nposition = [4, 3, 9]\ntarget = [1, 1, 1]\nsize = [30, 24]\n\n\
    [[light]]\ntype = 'directional'\ndirection = [1, 2, 3]\nirradiance = 2\n\n\
    [[object]]\nmesh = 'a.obj'\nmaterial = { preset = 'marble' }\n\n\
    [[object.deform]]\ntype = 'morph'\nmesh = 'b.obj'\nweight = { keyframes = [[0, 0], [4, 1]] }\n";

fn here() -> TempDir {
    let (a, b) = (pyramid(2.0, [1.0, 1.0, 2.0]), pyramid(2.6, [1.5, 1.0, 2.8]));
    folder(&[("a.obj", &a), ("b.obj", &b), ("m.toml", SCENE)])
}

/// Centroids of the triangles that `solve` writes.
fn centers(here: &TempDir, arguments: &str) -> Vec<[f64; 3]> {
    good(here, &format!("solve m.toml --device cpu -o a.csv {arguments}"));
    numbers(&read(here, "a.csv")).1.into_iter().map(|row| [row[1], row[2], row[3]]).collect()
}

fn near(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5))
}

#[test]
fn a_whole_morph_is_the_other_mesh_and_half_of_one_is_halfway() {
    let here = here();
    let (a, b) = (centers(&here, "--frame 0"), centers(&here, "--frame 0 --set object.0.mesh=b.obj"));
    assert!(near(&centers(&here, "--frame 4"), &b) && !near(&a, &b));
    let middle: Vec<[f64; 3]> = a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))).collect();
    assert!(near(&centers(&here, "--frame 2"), &middle));
    // A morph of weight 0 costs nothing.
    let (plan, _) = good(&here, "plan m.toml --frame 0");
    assert!(plan.contains("nothing deforms an object"), "{plan}");
    assert!(!good(&here, "plan m.toml --frame 1").0.contains("nothing deforms an object"));
}

#[test]
fn the_other_mesh_is_scaled_turned_and_subdivided_like_the_first() {
    let here = here();
    let own = |arguments: &str| centers(&here, &format!("{arguments} --set object.0.mesh=b.obj --frame 0"));
    // The second mesh is transformed as the first: by the first's extent of 2, size 6 is a factor of 3.
    let turn = "--set object.0.rotation=[20,30,40] --set object.0.position=[1,2,3]";
    assert!(near(&centers(&here, &format!("{turn} --frame 4")), &own(turn)));
    let scaled = centers(&here, "--set object.0.size=6 --frame 4");
    let (plain, rest) = (centers(&here, "--frame 4"), centers(&here, "--set object.0.size=6 --frame 0"));
    let apart = |all: &[[f64; 3]]| (0..3).map(|k| (all[2][k] - all[4][k]).powi(2)).sum::<f64>().sqrt();
    assert!((apart(&scaled) / apart(&plain) - 3.0).abs() < 1e-5 && apart(&rest) != apart(&scaled));
    let fine = "--set transport.hierarchy=butterfly --set transport.levels=2";
    assert!(near(&centers(&here, &format!("{fine} --frame 4")), &own(fine)));
    // Shrink-wrapped vertices keep their place on the mesh: on one that is 1.25 times as large they are farther out.
    std::fs::write(here.path().join("b.obj"), pyramid(2.5, [1.25, 1.25, 2.5])).unwrap();
    let wrap = "--set transport.hierarchy=shrink-wrap --set transport.levels=2";
    let [rest, end] = [0, 4].map(|frame| centers(&here, &format!("{wrap} --frame {frame}")));
    let larger: Vec<[f64; 3]> = rest.iter().map(|p| p.map(|x| 1.25 * x)).collect();
    assert!(rest.len() == 96 && near(&end, &larger), "{}", rest.len());
}

#[test]
fn frames_of_a_morph_do_not_depend_on_each_other() {
    let here = here();
    // The target mesh changes with frame 2.
    let moving = SCENE.replace("'b.obj'", "'to-%d.obj'");
    std::fs::write(here.path().join("m.toml"), moving).unwrap();
    for (frame, side) in [(0, 2.5), (1, 2.5), (2, 1.5)] {
        std::fs::write(here.path().join(format!("to-{frame}.obj")), pyramid(side, [1.0, 1.0, 2.8])).unwrap();
    }
    for device in ["--device cpu", ""] {
        good(&here, &format!("render m.toml --frames 0..2 -o f%d.png {device}"));
        for frame in 0..3 {
            good(&here, &format!("render m.toml --frame {frame} -o one.png {device}"));
            assert!(bytes(&here, &format!("f{frame}.png")) == bytes(&here, "one.png"), "{frame} {device:?}");
        }
        assert!(bytes(&here, "f1.png") != bytes(&here, "f2.png"));
    }
}

#[test]
fn what_turns_inside_out_or_folds_is_told() {
    let here = here();
    let told = |end: String| {
        std::fs::write(here.path().join("b.obj"), end).unwrap();
        good(&here, "solve m.toml --device cpu -o a.csv --frame 4").1
    };
    let whole = told(pyramid(2.0, [1.0, 1.0, -1.0]));
    assert!(whole.contains("turn 6 of 6 triangles inside out"), "{whole}");
    // A half turn about the vertical is valid, though every side faces the other way.
    let half = pyramid(2.0, [1.0, 1.0, 2.0])
        .replace("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0", "v 2 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0");
    let said = told(half);
    assert!(!said.contains("inside out"), "{said}");
    let flat = told(pyramid(2.0, [1.0, 0.0, 0.0]));
    assert!(flat.contains("inside out or leave them without an area"), "{flat}");
}

#[test]
fn what_does_not_match_is_refused() {
    let here = here();
    let write = |name: &str, text: &str| std::fs::write(here.path().join(name), text).unwrap();
    write("more.obj", &format!("{}v 9 9 9\nf 1 2 6\n", pyramid(2.0, [1.0; 3])));
    write("other.obj", &pyramid(2.0, [1.0; 3]).replace("f 2 3 5", "f 3 2 5"));
    // Two coincident vertices that the other file separates.
    let twice = pyramid(2.0, [1.0; 3]).replace("v 0 0 0\n", "v 0 0 0\nv 0 0 0\n").replace("f 1 2 5", "f 1 3 6");
    write("welded.obj", &twice.replace("f 4 3 2 1", "f 5 4 3 2"));
    write("parted.obj", &twice.replace("f 4 3 2 1", "f 5 4 3 2").replacen("v 0 0 0", "v 0 0 1", 1));
    let run = "render m.toml --device cpu -o a.png --frame 1 --set object.0.";
    for (more, words) in [
        (
            "deform.0.mesh=more.obj",
            &[
                "object.0.deform.0.mesh",
                "found 6 vertices in 7 triangles in",
                "expected 5 vertices in 6 triangles as in",
            ][..],
        ),
        ("deform.0.mesh=other.obj", &["do not match one to one; found other vertices from face 3 of"]),
        ("deform.0.mesh=gone.obj", &["gone.obj: there is no such mesh file"]),
        ("mesh=welded.obj --set object.0.deform.0.mesh=parted.obj", &["1 vertices that coincide with others in"]),
        ("deform.0.weight=11", &["object.0.deform.0.weight: out of range; found 11; expected -10 to 10"]),
        ("deform.0.weight=nan", &["object.0.deform.0.weight: not a finite number"]),
    ] {
        bad(&here, &format!("{run}{more}"), 2, words);
    }
    good(&here, &format!("{run}mesh=welded.obj --set object.0.deform.0.mesh=welded.obj"));
    let shape = "[[object]]\nshape = 'sphere'\nmaterial = { preset = 'marble' }\n[[object.deform]]\ntype = 'morph'\nmesh = 'a.obj'\nweight = 1\n";
    write("s.toml", shape);
    bad(
        &here,
        "render s.toml --device cpu -o a.png",
        2,
        &["s.toml:6: object.0.deform.0.mesh: a built-in shape has no file"],
    );
}
