//! `milkglass pareto` run as a program: what it prints, writes and refuses. No test depends on run times.

use crate::shell::{bad, folder, good, names, read};

/// A small and fast sweep.
const SMALL: &str = "pareto sphere --set object.0.detail=2 --quick --samples 40";

/// Header and rows of a CSV file.
fn rows(text: &str) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let cells = |record: &csv::StringRecord| record.iter().map(str::to_string).collect::<Vec<_>>();
    let header = cells(reader.headers().unwrap());
    (header, reader.records().map(|record| cells(&record.unwrap())).collect())
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn table_csv_and_svg_appear() {
    for device in ["", "--device cpu"] {
        let here = folder(&[]);
        let (out, err) =
            good(&here, &format!("{SMALL} {device} --methods blocks,links,links-kept,brute --csv a.csv --svg a.svg"));
        for words in
            ["sphere: 320 faces, 10 mm across, Marble", "light moves", "light rests", "own L2", "total L2", "1e-3"]
        {
            assert!(out.contains(words), "{words} {device}\n{out}");
        }
        assert!(out.contains("n/a: links-kept, light rests, angle 0.2 0.1: the same as links"), "{out}");
        assert!(out.contains("its ratio to that of blocks"), "{out}");
        assert!(device.is_empty() || err.is_empty(), "no bars but to a terminal: {err}");
        assert_eq!(names(here.path()), ["a.csv", "a.svg"]);

        // Two settings of three methods and one of the fourth, under both lights.
        let (header, rows) = rows(&read(&here, "a.csv"));
        let cell = |row: &[String], name: &str| row[header.iter().position(|h| h == name).unwrap()].clone();
        let number = |row: &[String], name: &str| cell(row, name).parse::<f64>().unwrap();
        assert_eq!(rows.len(), 14, "{rows:?}");
        let measured: Vec<_> = rows.iter().filter(|row| cell(row, "left_out").is_empty()).collect();
        assert_eq!(measured.len(), 12, "{rows:?}");
        for row in measured {
            assert!(number(row, "wall_low_ms") <= number(row, "wall_ms"), "{row:?}");
            assert!(number(row, "wall_ms") <= number(row, "wall_high_ms"), "{row:?}");
            assert_eq!((number(row, "samples"), number(row, "frames"), number(row, "faces")), (40.0, 5.0, 320.0));
            // These methods integrate over their leaves: own error and total error are equal, and almost zero for brute
            // force.
            assert_eq!((cell(row, "own_l2"), number(row, "leaves_l2")), (cell(row, "total_l2"), 0.0));
            let brute = cell(row, "method") == "brute";
            assert!(number(row, "own_l2") < if brute { 1e-3 } else { 0.1 }, "{row:?}");
            assert_eq!(cell(row, "links_per_face").is_empty(), brute);
            assert_eq!(cell(row, "device_ms").is_empty(), device.ends_with("cpu"), "{row:?}");
        }
        let svg = read(&here, "a.svg");
        assert!(svg.starts_with("<svg") && svg.contains("links-kept") && svg.contains("light rests"));
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn displaced_sources_leave_out_what_serves_radial_ones_only() {
    let here = folder(&[]);
    let line = format!("{SMALL} --device cpu --methods blocks,octree,brute --set transport.distance=table1");
    let (out, _) = good(&here, &line);
    for words in ["n/a: blocks, light moves", "n/a: octree, light rests", "radial distances only"] {
        assert!(out.contains(words), "{words}\n{out}");
    }
}

#[test]
fn methods_can_be_chosen_and_the_budget_leaves_some_out() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("{SMALL} --device cpu --methods brute --budget 1e-9"));
    assert!(out.contains("n/a: brute, light moves: would take") && out.contains("beyond --budget"), "{out}");
    assert!(!out.contains("links-kept"), "{out}");
}

#[test]
fn bad_arguments_are_named() {
    let here = folder(&[("dark.toml", "[[object]]\nshape = 'sphere'\ndetail = 1\nmaterial = { preset = 'marble' }\n")]);
    let cases: &[(&str, &[&str])] = &[
        ("--methods links,magic", &["--methods: unknown method; found magic; expected ", "links-kept"]),
        ("--repeat 4", &["--repeat", "5"]),
        ("--samples 0", &["--samples"]),
        ("--samples -3", &["--samples"]),
        ("--budget 0", &["--budget: out of range"]),
        ("--budget nan", &["--budget: out of range"]),
        ("--csv a.svg", &["--csv: the name says the format", "a.svg", ".csv"]),
        ("--svg a", &["--svg: the name says the format", ".svg"]),
        ("--csv gone/a.csv", &["gone/a.csv: could not be written"]),
    ];
    for (rest, words) in cases {
        bad(&here, &format!("{SMALL} --device cpu --methods brute {rest}"), 2, words);
    }
    bad(&here, "pareto dark.toml --quick --device cpu", 2, &["light: no light shines"]);
    bad(&here, "pareto", 2, &["SCENE"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_walk_that_takes_too_long_is_refused_before_anything_is_measured() {
    let here = folder(&[]);
    for (truth, words) in [
        ("walk --set transport.walk_error=1e-4", ["transport.walk_error = 0.0001 takes about", "at most 5 s"]),
        ("walk --set transport.walks=200000000", ["transport.walks = 200000000 takes about", "at most 5 s"]),
        ("walk:6", ["found 6 s", "at most 5 s"]),
    ] {
        let line = format!("{SMALL} --device cpu --methods brute --limit-time 5s --csv a.csv --truth {truth}");
        let err = bad(&here, &line, 2, &words);
        assert!(err.contains("--limit-time: "), "{err}");
    }
    let fits = format!("{SMALL} --device cpu --methods brute --limit-time 60s --truth walk --set transport.walks=3000");
    assert!(good(&here, &fits).0.contains("a walk of 3000 photons a channel"));
    bad(&here, &format!("{SMALL} --limit-time never"), 2, &["--limit-time", "such as 90s"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn errors_against_a_walk_are_those_of_the_model() {
    let here = folder(&[]);
    let walk = "solve sphere --set object.0.detail=2 --transport walk --set transport.walks=40000 -o walk.csv";
    good(&here, walk);
    let line = format!("{SMALL} --methods blocks,brute --truth walk.csv --csv out.csv --svg out.svg");
    let (out, _) = good(&here, &line);
    assert!(out.contains("truth:  walk.csv; L2 of means over patches"), "{out}");
    assert!(read(&here, "out.svg").contains("against a random walk"));
    let text = read(&here, "out.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let mut rows = 0;
    for row in reader.records().map(Result::unwrap) {
        let cell = |name: &str| row[header.iter().position(|own| own == name).unwrap()].parse::<f64>();
        // The dipole on a ball of marble is about a tenth off, however finely it is solved.
        for channel in ["r", "g", "b"] {
            let error = cell(&format!("truth_l2_{channel}")).unwrap();
            assert!((0.04..0.25).contains(&error), "{error}");
        }
        assert!((1e-3..0.1).contains(&cell("truth_noise").unwrap()));
        rows += 1;
    }
    assert!(rows > 3, "{rows}");

    std::fs::write(here.path().join("short.csv"), "area,B_r,B_g,B_b,se_r,se_g,se_b\n1,1,1,1,0,0,0\n").unwrap();
    std::fs::write(here.path().join("odd.csv"), "area,B_r,B_g,B_b,se_r,se_g,se_b\n1,1,1,one,0,0,0\n").unwrap();
    std::fs::write(here.path().join("less.csv"), "area,B_r,B_g,B_b,se_r,se_g\n").unwrap();
    for (truth, told) in [
        ("short.csv", ["short.csv", "of another mesh; found 1 rows; expected 320"]),
        ("odd.csv", ["odd.csv:2", "found one"]),
        ("less.csv", ["less.csv", "expected se_b"]),
        ("walk:0", ["--truth", "expected walk:SECONDS"]),
        ("gone.csv", ["gone.csv", "can't be read"]),
    ] {
        bad(&here, &format!("{SMALL} --methods blocks --truth {truth}"), 2, &told);
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_scene_that_is_subdivided_is_measured_on_its_own_triangles() {
    let (out, err) = good(
        &folder(&[]),
        &format!("{SMALL} --set transport.subdivide=2 --methods blocks --truth walk --set transport.walks=3000"),
    );
    assert!(err.contains("transport.subdivide = 0 here"), "{err}");
    assert!(out.contains("sphere: 320 faces") && out.contains("truth:  a walk of 3000 photons"), "{out}");
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn all_methods_are_measured_side_by_side() {
        for device in ["", "--device cpu"] {
            let here = folder(&[]);
            let (out, _) = good(&here, &format!("{SMALL} {device} --csv a.csv --svg a.svg --budget 60"));
            let (header, rows) = rows(&read(&here, "a.csv"));
            let cell = |row: &[String], name: &str| row[header.iter().position(|h| h == name).unwrap()].clone();
            let number = |row: &[String], name: &str| cell(row, name).parse::<f64>().unwrap();
            let mut names: Vec<String> = rows.iter().map(|row| cell(row, "method")).collect();
            names.dedup();
            let dipole = ["blocks", "blocks-kept", "links", "links-sample", "links-kept", "octree", "brute"];
            assert_eq!(names, [&dipole[..], &["diffusion", "diffusion-kept"]].concat());
            assert!(out.contains("against its own leaf sums") && out.contains("against the area integral"), "{out}");
            for row in rows.iter().filter(|row| cell(row, "left_out").is_empty()) {
                let octree = cell(row, "method") == "octree";
                assert!(number(row, "own_l2") < 0.2, "{row:?}");
                // The octree sums midpoints, has no links, and is timed by wall clock only.
                assert_eq!(number(row, "leaves_l2") > 0.0, octree, "{row:?}");
                assert_eq!(cell(row, "device_ms").is_empty(), octree || device.ends_with("cpu"), "{row:?}");
                // Diffusion is another equation.
                let diffusion = cell(row, "method").starts_with("diffusion");
                assert_eq!(cell(row, "total_l2").is_empty(), diffusion, "{row:?}");
                // At most all pairs of faces, for each channel group.
                let links = cell(row, "links_per_face");
                assert!(links.is_empty() || number(row, "links_per_face") <= 3.0 * 320.0, "{row:?}");
            }
        }
    }
}
