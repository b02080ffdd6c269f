//! A factor of 1 + 3e-5 on what a kernel writes hides in the tolerances of single values. The mean over all values
//! shows it.

use super::mutants;
use super::stages::all;
use crate::devices::on_devices_each;
use crate::shell::folder;
use milkglass::internals::gpu::{Given, replacements, source, sources};
use milkglass::internals::layout::{BUFFER_IDS, Number};
use milkglass::internals::pipeline::frame::owner;
use milkglass::measure::conform::conform_stages;
use milkglass::measure::fixtures::{Fixture, fixtures};
use milkglass::measure::leaning::blame;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

/// The kernel's source with its last plain assignment to a buffer of floats multiplied by the factor, if it has one.
fn multiplied(kernel: &str) -> Option<String> {
    let text = source(kernel)?;
    let float = |name: &str| {
        let slot = BUFFER_IDS.iter().find(|slot| slot.spec().name == name);
        slot.is_some_and(|slot| {
            (slot.spec().words)()
                .iter()
                .all(|word| word.number == Number::Float && !word.path.contains(|c: char| c.is_alphabetic()))
        })
    };
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let found = lines.iter().rposition(|line| {
        let name = line.trim().split('[').next().unwrap_or_default();
        line.trim().ends_with(';') && line.contains("] ") && line.contains("= ") && float(name)
    })?;
    let (left, right) = lines[found].split_once("= ")?;
    lines[found] = format!("{left}= 1.00003 * ({});", right.trim_end_matches(';'));
    Some(lines.join("\n") + "\n")
}

/// Devices may round a division either way. An edge of a coplanar triangle whose line meets the receiver is where that
/// once showed: both ends lie at the same place but for rounding.
#[test]
fn a_division_may_round_down() {
    let here = folder(&[]);
    let (kernel, edges) = ("transport/diffusion/near_layers/layers", "transport/diffusion/edges.glsl");
    let text = source(edges).unwrap();
    let mut rounded = text.to_string();
    for (exact, other) in [
        ("w1 = t1 / (S", "w1 = 0.99999994 * t1 / (S"),
        ("? (q - p) / size", "? vec3(1, 0.99999994, 1) * (q - p) / size"),
    ] {
        assert!(rounded.contains(exact));
        rounded = rounded.replace(exact, other);
    }
    std::fs::create_dir_all(here.path().join("transport/diffusion")).unwrap();
    std::fs::write(here.path().join(edges), rounded).unwrap();
    let file = here.path().join("layers.comp");
    std::fs::write(&file, source(kernel).unwrap().as_ref()).unwrap();
    let words = replacements(kernel, &file, &Given::default()).unwrap().remove(0).1;
    let fixture = fixtures("diffusion under every light").unwrap();
    on_devices_each(&fixture, |device, fixture| {
        let device = device.replacing(kernel, words.clone()).unwrap();
        let rows = conform_stages(&device, fixture, &["near_layers".to_string()]).unwrap();
        let faults: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
        assert!(rows.len() == 1 && faults.is_empty(), "{faults:?}");
    });
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn a_systematic_factor_is_reported() {
        let mut small: Vec<&Fixture> = all().iter().collect();
        small.retain(|fixture| fixture.state.data.triangles.len() < 20_000);
        small.sort_by_key(|fixture| fixture.state.data.triangles.len());
        let here = folder(&[]);
        let kernels: Vec<(&str, String)> = sources()
            .filter(|name| !name.ends_with(".glsl") && !name.starts_with("measure/"))
            .filter_map(|name| Some((name, multiplied(name)?)))
            .collect();
        assert!(kernels.len() > 25, "{} kernels", kernels.len());
        let noticed = Mutex::new(BTreeMap::<String, BTreeSet<String>>::new());
        on_devices_each(&kernels, |device, (kernel, text)| {
            let file = here.path().join(format!("{}.comp", kernel.replace('/', "-")));
            std::fs::write(&file, text).unwrap();
            let device =
                device.replacing(kernel, replacements(kernel, &file, &Given::default()).unwrap().remove(0).1).unwrap();
            // The mean over ever more values, until it shows.
            let stage = [owner(kernel).unwrap().name.to_string()];
            let mut rows = Vec::new();
            let seen = small.iter().any(|fixture| {
                rows.extend(conform_stages(&device, fixture, &stage).unwrap());
                blame(&mut rows);
                rows.iter().any(|row| !row.faults.is_empty())
            });
            let mut noticed = noticed.lock().unwrap();
            let own = noticed.entry(device.name().to_string()).or_default();
            if seen {
                own.insert(kernel.to_string());
            }
        });
        for kernels in noticed.into_inner().unwrap().values() {
            mutants::check("factor", kernels);
        }
    }
}
