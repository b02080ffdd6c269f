//! Cost and error of one triangle-receiver form factor on every device, by one sample and by the edge form with 3, 6
//! and 12 nodes per edge.
//!
//! Times are device times, medians of several runs; ratios are against one sample in the same run. Errors are scaled,
//! |F - F_ref| / R_full, over pairs whose nearer source is more than 1e-4 of the longest edge from the triangle's
//! plane. The edge form is applied to every pair here; the renderer uses it for near pairs only.

#[path = "../tests/population/mod.rs"]
mod population;

use milkglass::error::Result;
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::gpu::{Device, Instance, SingleKernel};
use milkglass::measure::report::{Bench, Page};
use milkglass::measure::statistics::median;
use milkglass::measure::stress::factor::Pair;
use milkglass::measure::table::Table;
use population::seeded::percentile;
use population::{heights, longest, population};

use super::Asked;

static SPIRV: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/bench-kernels-pair.spv"));
/// Number of pairs whose error is measured.
const CHECKED: usize = 4000;
/// Number of timed triangles, and receivers per triangle.
const TIMED: [usize; 2] = [32768, 16];

/// A pair as the kernel reads it: corners relative to the receiver, then the dipoles; lengths in units of the longest
/// edge.
fn record(pair: &Pair) -> Vec<f32> {
    let length = longest(pair.triangle);
    let dipoles = pair.dipoles();
    let corners = pair.triangle.iter().flat_map(|&corner| ((corner - pair.point) / length).to_array());
    let each = |f: fn(&Dipole) -> f64| dipoles.each_ref().map(f);
    let [sigma, z_real, z_virtual] = [each(|d| d.sigma), each(|d| d.z_real), each(|d| d.z_virtual)];
    let media = [sigma.map(|x| x * length), z_real.map(|x| x / length), z_virtual.map(|x| x / length)];
    corners.chain(media.into_iter().flatten()).chain(each(|d| d.strength)).map(|x| x as f32).collect()
}

/// Form factors of three channels per record, and the median time per pair in nanoseconds.
fn form(device: &Device, nodes: u32, records: &[Vec<f32>], receivers: usize) -> Result<(Vec<f64>, f64)> {
    let head = [records.len() as u32, receivers as u32].into_iter().flat_map(u32::to_ne_bytes);
    let input = head.chain(records.iter().flatten().flat_map(|x| x.to_ne_bytes())).collect();
    let mut buffers = [input, vec![0; 12 * records.len()]];
    let alone = SingleKernel { name: "pair", spirv: SPIRV, constants: &[nodes] };
    // The first run builds the pipeline and is not counted.
    let timings = alone.run(device, &mut buffers, records.len() as u64, 8)?;
    let ms = median(timings.iter().skip(1).map(|timing| timing.milliseconds).collect());
    let number = |b: &[u8]| f64::from(f32::from_ne_bytes([b[0], b[1], b[2], b[3]]));
    Ok((buffers[1].chunks_exact(4).map(number).collect(), ms * 1e6 / (records.len() * receivers) as f64))
}

/// Every form of the form factor on every device.
pub fn form_factor(_: &Asked, _: &Bench<'_>, page: &mut Page) -> Result<()> {
    let pairs = population(1, CHECKED);
    let exact: Vec<[f64; 3]> = pairs.iter().map(Pair::exact).collect();
    let records: Vec<_> = pairs.iter().map(record).collect();
    let many: Vec<_> = records.iter().cycle().take(TIMED[0]).cloned().collect();
    let instance = Instance::open(false)?;
    for adapter in instance.adapters()?.into_iter().filter(|adapter| adapter.unusable.is_none()) {
        let device = Device::open(&instance, &adapter)?;
        page.head(&format!("{}, {}: three channels, both sources", adapter.name, adapter.driver));
        let mut rows = Vec::new();
        for nodes in [0, 3, 6, 12] {
            let (values, _) = form(&device, nodes, &records, 1)?;
            let mut errors = Vec::new();
            for (k, pair) in pairs.iter().enumerate() {
                let (dipoles, heights) = (pair.dipoles(), heights(pair));
                let error = |c: usize| (values[3 * k + c] - exact[k][c]).abs() / dipoles[c].total();
                errors.extend((0..3).filter(|&c| heights[c] > 1e-4).map(error));
            }
            let (_, ns) = form(&device, nodes, &many, TIMED[1])?;
            rows.push((nodes, ns, percentile(&mut errors, 0.99), percentile(&mut errors, 1.0)));
        }
        let name = |nodes: u32| match nodes {
            0 => "one sample, second moment".to_string(),
            nodes => format!("edge form, {nodes} nodes"),
        };
        page.small_table(&Table::of(
            &rows,
            &[
                ("form", "", &|row| name(row.0)),
                ("ns a pair", "", &|row| format!("{:.2}", row.1)),
                ("dearer", "", &|row| format!("{:.1}x", row.1 / rows[0].1)),
                ("p99", "", &|row| format!("{:.1e}", row.2)),
                ("max", "", &|row| format!("{:.1e}", row.3)),
            ],
        ));
    }
    Ok(())
}
