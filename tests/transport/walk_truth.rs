//! The random walk against walks of another program, in a folder that `MILKGLASS_TRUTH` names.

use std::fs;
use std::path::Path;

use milkglass::internals::lighting::fresnel;
use milkglass::internals::pipeline::plan::Change;
use milkglass::internals::session::patches::patches;
use milkglass::{Device, Goal, Options, Scene, Session, ShadingMethod};

/// Standard error of a patch, as a share of its light, up to which it is compared.
const MOST_NOISE: f64 = 0.2;

/// Rows of a file: area, E, B, standard error.
fn rows(path: &Path) -> Vec<[f64; 4]> {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let row = |line: &str| {
        let mut cells = line.split(',').skip(1).map(|cell| cell.trim().parse().unwrap());
        [0; 4].map(|_| cells.next().unwrap())
    };
    text.lines().skip(2).map(row).collect()
}

/// Light from all sides, as much of which enters a medium of this index as if there were no boundary; or the sun.
fn light(kind: &str, sun: &str, eta: f64) -> String {
    let radiance = 1.0 / (std::f64::consts::PI * (1.0 - fresnel::diffuse_external_exact(eta)));
    match kind {
        "const" => format!("{{ type = 'environment', radiance = {radiance} }}"),
        _ => format!("{{ type = 'directional', direction = {sun}, irradiance = 1 }}"),
    }
}

/// A session that has walked in this mesh.
fn walked(mesh: &Path, medium: &str, light: &str, device: &Option<Device>) -> Session {
    let walks = std::env::var("MILKGLASS_WALKS").unwrap_or("100000".into());
    let sets =
        [format!("light=[{light}]"), format!("object.0.material.preset={medium}"), format!("transport.walks={walks}")];
    let scene = Scene::load_with(mesh.to_str().unwrap(), &sets).unwrap();
    let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&scene, device.as_ref(), options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

#[test]
#[ignore = "needs MILKGLASS_TRUTH, a folder with sphere.obj, torus.obj and their files"]
fn patches_agree_with_another_walk() {
    let Ok(folder) = std::env::var("MILKGLASS_TRUTH") else {
        println!("NOT COMPARED: MILKGLASS_TRUTH names no folder");
        return;
    };
    let folder = Path::new(&folder);
    let device = Device::best().unwrap().filter(|_| std::env::var_os("MILKGLASS_TRUTH_CPU").is_none());
    let (mut all, mut within, mut squares) = (0, 0, 0.0);
    for (shape, sun) in [("sphere", "[0, 0, 1]"), ("torus", "[1, 0, 1]")] {
        for (medium, eta) in [("marble", 1.5), ("wholemilk", 1.3), ("skin1", 1.3)] {
            for kind in ["const", "dir"] {
                let mut session = walked(&folder.join(format!("{shape}.obj")), medium, &light(kind, sun, eta), &device);
                let faces = session.faces().unwrap();
                let parts = patches(session.state(), 0);
                let places = session.prepared().places(0);
                for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
                    let truth = rows(&folder.join(format!("{shape}-{medium}-{name}-{kind}.csv")));
                    assert_eq!(truth.len(), faces.len());
                    let (mut own, mut count, mut square, mut worst) = (0, 0, 0.0, 0.0f64);
                    let (mut bias, mut total, mut entered, mut same) = (0.0, 0.0, 0.0, 0.0);
                    for part in &parts {
                        let inside = |face: &usize| part.contains(&places[*face]);
                        let (mut sum, mut variance, mut light) = (0.0, 0.0, 0.0);
                        for face in (0..faces.len()).filter(inside) {
                            let ([area, e, b, se], found) = (truth[face], &faces[face]);
                            (entered, same) = (entered + area * e, same + area * (found.irradiance[c] - e).abs());
                            light += area * b;
                            sum += area * (found.radiosity[c] - b);
                            total += area * b;
                            variance += (area * se).powi(2) + (area * found.noise.unwrap()[c]).powi(2);
                        }
                        bias += sum;
                        // Three standard errors of a handful of photons mean nothing.
                        if variance.sqrt() >= MOST_NOISE * light {
                            continue;
                        }
                        let score = sum / variance.sqrt();
                        count += 1;
                        (own, square) = (own + usize::from(score.abs() <= 3.0), square + score * score);
                        worst = worst.max(score.abs());
                    }
                    // The same light enters, but for triangles in half shadow.
                    assert!(same < 3e-3 * entered, "{same} {entered}");
                    (all, within, squares) = (all + count, within + own, squares + square);
                    println!(
                        "{shape} {medium} {name} {kind}: {own} of {count} of {} within 3, rms {:.2}, worst {worst:.1}, whole {:+.2e}",
                        parts.len(),
                        (square / f64::from(count as u32)).sqrt(),
                        bias / total
                    );
                }
                println!("  {:?}", session.walk_reports()[0]);
            }
        }
    }
    println!("{within} of {all} within 3, rms {:.3}", (squares / f64::from(all as u32)).sqrt());
    assert!(within as f64 >= 0.99 * all as f64);
}
