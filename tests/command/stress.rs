//! `milkglass stress` run as a program, with the whole table on the default device and on the CPU.

use crate::shell::{bad, folder, good, read};

/// Runs the whole table, checks that every case passes, and returns its rows.
fn table(device: &str) -> Vec<csv::StringRecord> {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("stress --csv stress.csv {device}"));
    assert!(out.ends_with(" cases, all pass\n"), "{out}");
    let text = read(&here, "stress.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<_> = reader.headers().unwrap().iter().map(str::to_string).collect();
    assert_eq!((header[0].as_str(), header[1].as_str(), header[10].as_str()), ("case", "finite", "verdict"));
    let rows: Vec<_> = reader.into_records().map(Result::unwrap).collect();
    for row in &rows {
        assert_eq!((&row[1], &row[10]), ("yes", "passes"), "{row:?}");
        assert!(!row[11].is_empty() && !row[12].is_empty(), "{row:?}");
        // Errors are within their bounds.
        for (error, bound) in [(2, 4), (3, 5), (6, 8), (7, 9)] {
            let number = |k: usize| row[k].parse::<f64>().unwrap();
            assert!(number(error) <= number(bound) && number(bound) < 1.0, "{row:?}");
        }
    }
    rows
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_table_passes_on_the_default_device() {
    let names: Vec<_> = table("").iter().map(|row| row[0].to_string()).collect();
    let asked = [
        "inside a triangle",
        "on an edge",
        "on a vertex",
        "1e-7 off",
        "sliver",
        "zero area",
        "zero-area faces",
        "alpha' 0",
        "alpha' 1-1e-9",
        "sigma_a 0",
        "sigma_a 1e6 sigma_s'",
        "eta 0.7",
        "eta 1.0001",
        "eta 2.4",
        "eta 4",
        "mean free path 1e-6 of the object",
        "mean free path 1e6 of the object",
        "scene scale 1e-6",
        "scene scale 1e6",
        "1e6 extents from the origin",
        "as thin as z_r",
        "coincident sheets",
        "grazing",
        "tangent",
        "intensity 1e-30",
        "intensity 1e30",
        "one lit face",
    ];
    for part in asked {
        assert!(names.iter().any(|name| name.contains(part)), "no case for {part}: {names:?}");
    }
}

#[test]
fn one_case_alone_and_none() {
    let here = folder(&[]);
    let (out, _) = good(&here, "stress --only tangent --device cpu");
    assert!(out.ends_with("2 cases, all pass\n"), "{out}");
    bad(&here, "stress --only nothing-of-the-kind --device cpu", 2, &["no case has this", "alpha' 0; "]);
    bad(&here, "stress --only tangent --device nowhere", 3, &["nowhere"]);
    bad(&here, "stress --only tangent --device cpu --csv no/such/folder.csv", 2, &["folder.csv"]);
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn the_table_passes_on_the_cpu() {
        assert!(table("--device cpu").len() > 30);
    }
}
