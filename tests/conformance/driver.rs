//! How drivers compile nested loops. Mesa's llvmpipe (22.3.6, LLVM 15) miscompiles one structure: if the inner loop
//! assigns a variable unconditionally and the variable indexes a buffer after the loop, lanes that leave the loop early
//! get the value of lanes that continue. `tests/kernels/loops.comp` has that structure and the ones that kernels use
//! instead.

use crate::devices::on_devices;
use milkglass::internals::gpu::{Device, SingleKernel};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::measure::norms::worst;
use milkglass::measure::probe::{probe, seeded};
use milkglass::measure::reference::verify;
use milkglass::scene::Scene;

static SPIRV: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-loops.spv"));
const LANES: usize = 64;

/// The sum of one column, as the shader's header comment defines it.
fn expected(numbers: &[u32], lane: usize) -> u32 {
    let column: Vec<u32> = numbers.iter().skip(lane).step_by(LANES).copied().collect();
    let (mut row, mut sum) = (0, 0u32);
    while row < column.len() {
        let far = !column[row].is_multiple_of(4);
        if far && column[row] / 4 % 2 == 1 {
            sum += 7 * row as u32 + 1;
        }
        row += if far { 3 } else { 1 };
    }
    sum
}

/// Number of the 64 lanes that a device gets wrong with this loop structure.
fn wrong(device: &Device, shape: u32, rows: usize) -> usize {
    let numbers = seeded(rows * LANES);
    let input = [&[rows as u32], &numbers[..]].concat();
    let mut buffers = [bytes(&input), vec![0xA5; 4 * LANES]];
    let alone = SingleKernel { name: "loops", spirv: SPIRV, constants: &[shape] };
    alone.run(device, &mut buffers, LANES as u64, 1).unwrap();
    let sum = |lane: usize| u32::from_ne_bytes(buffers[1][4 * lane..4 * lane + 4].try_into().unwrap());
    (0..LANES).filter(|&lane| sum(lane) != expected(&numbers, lane)).count()
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

/// The three loop structures that kernels use give the CPU's results on every device.
#[test]
fn the_loops_that_kernels_use_are_right() {
    on_devices(|device| {
        for (shape, name) in [(1, "sentinel"), (2, "flat"), (3, "counted")] {
            for rows in [1, 7, 300] {
                assert_eq!(wrong(device, shape, rows), 0, "{}: the {name} loop over {rows} rows", device.name());
            }
        }
    });
}

/// Reports every driver that miscompiles the forbidden structure, which is no failure. On a driver known for it the
/// error must appear; otherwise this kernel no longer tests the rule.
#[test]
fn the_loop_that_no_kernel_may_have_is_wrong_where_it_is_known_to_be() {
    on_devices(|device| {
        let wrong = wrong(device, 0, 300);
        let (name, driver) = (device.name(), device.driver());
        if wrong > 0 {
            println!(
                "KNOWN: {name}, {driver}: nested loops with an unconditional assignment, {wrong} of 64 lanes wrong"
            );
        } else {
            println!("{name}, {driver}: nested loops with an unconditional assignment are right");
        }
        let known = name.contains("llvmpipe") && driver.contains("22.3.6");
        assert!(!known || wrong > 0, "{name}, {driver}: the miscompiled shape is no longer seen");
    });
}

/// What kernels rely on is there; the fault above is found by its probe, too.
#[test]
fn probes_agree_with_what_is_known() {
    on_devices(|device| {
        let facts = probe(device).unwrap();
        assert_eq!(facts.len(), 15);
        for fact in facts.iter().filter(|fact| fact.needed) {
            assert!(fact.right, "{}: {fact:?}", device.name());
        }
        let known = device.name().contains("llvmpipe") && device.driver().contains("22.3.6");
        for fact in &facts[..2] {
            assert!(!known || !fact.right, "{}: {fact:?}", device.name());
        }
    });
}

/// The comparison can fail: other numbers have other sums.
#[test]
fn a_wrong_sum_is_seen() {
    let numbers = seeded(300 * LANES);
    let mut other = numbers.clone();
    (0..LANES).for_each(|lane| other[lane] ^= 7);
    assert!((0..LANES).filter(|&lane| expected(&numbers, lane) != expected(&other, lane)).count() > LANES / 2);
}

/// A crumpled heap of 1,600 triangles, all lit and near each other: their edge forms take more than 65,535 loop
/// iterations per invocation, where llvmpipe silently ends loops.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn long_lists_of_near_triangles_are_taken_to_the_end() {
    let library = tempfile::tempdir().unwrap();
    let mut next = seeded(320 * LANES).into_iter().map(|n| f64::from(n) / f64::from(1 << 24) - 0.5);
    let mut mesh = String::new();
    for triangle in 0..1600 {
        let middle: Vec<f64> = next.by_ref().take(3).collect();
        for _ in 0..3 {
            let [x, y, z] = [0, 1, 2].map(|k| 0.2 * middle[k] + 0.7 * next.next().unwrap());
            mesh += &format!("v {x} {y} {z}\n");
        }
        let first = 3 * triangle + 1;
        mesh += &format!("f {first} {} {}\n", first + 1, first + 2);
    }
    std::fs::write(library.path().join("heap.obj"), mesh).unwrap();
    let lights = ["[1, 2, 3]", "[-1, -2, -3]"].map(|direction| {
        format!("[[light]]\ntype = \"directional\"\ndirection = {direction}\nirradiance = [1, 1, 1]\nshadows = false\n")
    });
    let rest = "[transport]\ntolerance = 1e-4\n[[object]]\nmesh = \"heap.obj\"\nsize = 20\n[object.material]\npreset = \"marble\"\n";
    let file = library.path().join("heap.toml");
    std::fs::write(&file, lights.concat() + rest).unwrap();
    let mut scene = Scene::load_with(file.to_str().unwrap(), &[]).unwrap();
    // Its triangles are long, and stay so.
    scene.transport.divided = true;
    on_devices(|device| {
        let options = Options { goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(&scene, Some(device), options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.fetch(&[BufferId::runs]).unwrap();
        let longest = session.state().runs().map(|run| run.edge).max().unwrap();
        assert!(longest > 1400, "{longest} near triangles a block: a poor test");
        let error = worst(&verify(&mut session, 100, 1).unwrap());
        assert!(error.max < 1e-3, "{}: {error:?}", device.name());
    });
}
