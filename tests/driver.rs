//! What drivers make of nested loops. Mesa's llvmpipe (22.3.6, LLVM 15) gets one shape wrong: lanes that leave the inner
//! loop early keep, of a variable that the loop assigns unconditionally, the value of those that go on, once the variable
//! indexes a buffer after the loop. `tests/kernels/loops.comp` has that shape and the ones that kernels use instead.

mod devices;

use devices::on_devices;
use milkglass::gpu::{Alone, Device};

static SPIRV: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tests-kernels-loops.spv"));
const LANES: usize = 64;

/// Rows of numbers, one column a lane; seeded, so that lanes leave their loops at different times.
fn numbers(rows: usize) -> Vec<u32> {
    let mut state = 0x2545_f491u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state >> 8
    };
    (0..rows * LANES).map(|_| next()).collect()
}

/// The sum of one column, from the words of the shader's first comment.
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

/// How many of the 64 lanes a device gets wrong with a shape of the loop.
fn wrong(device: &Device, shape: u32, rows: usize) -> usize {
    let numbers = numbers(rows);
    let input = [&[rows as u32], &numbers[..]].concat();
    let mut buffers = [bytes(&input), vec![0xA5; 4 * LANES]];
    let alone = Alone { name: "loops", spirv: SPIRV, constants: &[shape] };
    alone.run(device, &mut buffers, LANES as u64, 1).unwrap();
    let sum = |lane: usize| u32::from_ne_bytes(buffers[1][4 * lane..4 * lane + 4].try_into().unwrap());
    (0..LANES).filter(|&lane| sum(lane) != expected(&numbers, lane)).count()
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

/// Proves that every device runs the three shapes of loop that kernels use as the CPU does.
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

/// Names every driver that gets the shape wrong which no kernel may have. Its being wrong is no failure; but a driver
/// known for it must be seen, or else this kernel has lost the shape and the rule its proof.
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

/// Proves that the comparison can fail: of other numbers the sums are others.
#[test]
fn a_wrong_sum_is_seen() {
    let numbers = numbers(300);
    let mut other = numbers.clone();
    (0..LANES).for_each(|lane| other[lane] ^= 7);
    assert!((0..LANES).filter(|&lane| expected(&numbers, lane) != expected(&other, lane)).count() > LANES / 2);
}
