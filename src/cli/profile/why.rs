//! Why a frame takes as long as it does, as a page of one screen.

use crate::cli::table;
use milkglass::measure::profile::why::{Stage, Why};
use milkglass::measure::profile::{FinerRates, Profile, Rates};
use milkglass::measure::statistics::Interval;

/// Rows of the table; the other stages share the last one.
const ROWS: usize = 16;
/// Lines of the driver's own statistics.
const STATISTICS: usize = 6;
/// Columns of a stage's parts.
const SHARES: usize = 5;

pub(super) fn text(found: &Profile, why: &Why) -> String {
    let mut text = format!("{}, on {}, {}\n", found.scene, found.device, found.driver);
    let parts = why.frame_ms;
    let share = |ms: f64| percent(ms / parts.wall);
    text += &format!(
        "a frame: {:.3} ms = stages' own work {} + launches {} + barriers {}\n         + {} submissions {} + rest of the host {}\n",
        parts.wall,
        share(parts.work),
        share(parts.launches),
        share(parts.barriers),
        why.submissions,
        share(parts.submissions),
        share(parts.host)
    );
    let cost = why.overheads_us;
    let us = |interval: Interval| format!("{:.2} us [{:.2}, {:.2}]", interval.value, interval.low, interval.high);
    text += &format!("on the device: dispatch {}, barrier {}\n", us(cost.dispatch), us(cost.barrier));
    text += &format!(
        "by the host:   dispatch {}, barrier {},\n               submission and wait {}\n",
        us(cost.dispatch_host),
        us(cost.barrier_host),
        us(cost.submission)
    );
    if let Some((all, finer)) = found.rates.as_ref().zip(why.rates.as_ref()) {
        text += &rates(all, finer);
        text += "model: ms at these rates; from mem (memory) to wait: parts of ms in %; lanes: active ones, mean\n";
    }
    text += "\n";

    let mut stages: Vec<&Stage> = why.stages.iter().collect();
    stages.sort_by(|a, b| b.ms.total_cmp(&a.ms));
    let rest = stages.split_off(stages.len().min(ROWS));
    let mut rows: Vec<Vec<String>> = stages.iter().map(|stage| cells(stage)).collect();
    if !rest.is_empty() {
        let sum = |value: fn(&Stage) -> f64| rest.iter().map(|stage| value(stage)).sum::<f64>();
        let mut row = vec![format!("{} others", rest.len()), format!("{:.3}", sum(|s| s.ms))];
        row.push(format!("{:.3}", sum(|s| s.model_ms.unwrap_or(0.0))));
        row.extend([""; SHARES + 2].map(String::from));
        row.push(format!("{:.1}", sum(|s| s.creation_ms)));
        row.push(format!("{:.1}", sum(|s| s.first_run_ms.unwrap_or(0.0))));
        rows.push(row);
    }
    let header =
        ["stage", "ms", "model", "bound by", "mem", "arith", "launch", "miss", "wait", "lanes", "create", "first"];
    text += &table(header, rows);
    let created: f64 = why.stages.iter().map(|stage| stage.creation_ms).sum();
    let first: f64 = why.stages.iter().filter_map(|stage| stage.first_run_ms).sum();
    let pipelines: usize = why.stages.iter().map(|stage| stage.pipelines).sum();
    text += &format!(
        "\ncreate: ms to create {pipelines} pipelines, {created:.1} in all; first: ms that first runs take longer, {first:.1} in all\n"
    );
    let known = why.stages.iter().flat_map(|stage| &stage.statistics).take(STATISTICS);
    for (kernel, statistics) in known {
        let values: Vec<String> = statistics.iter().take(4).map(|(name, value)| format!("{name} {value}")).collect();
        text += &format!("{kernel}: {}\n", values.join(", "));
    }
    if !why.counters.is_empty() {
        text += &format!("{} hardware counters: --save lists their names\n", why.counters.len());
    }
    why.lacks.iter().for_each(|lack| text += &format!("the driver lacks {lack}\n"));
    text
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// The device's rates in two lines.
fn rates(rates: &Rates, finer: &FinerRates) -> String {
    let binary =
        |bytes: u64| if bytes < 1 << 20 { format!("{} KiB", bytes >> 10) } else { format!("{} MiB", bytes >> 20) };
    let load = |(bytes, rate): &(u64, f64)| format!("{:.2} in {}", rate * 1e-9, binary(*bytes));
    let loads: Vec<String> = finer.loads.iter().map(load).collect();
    let giga = [2.0 * rates.fma, rates.exp, finer.divide, finer.integer, finer.shared, finer.atomic];
    let [flop, exp, divide, integer, shared, atomic] = giga.map(|rate| rate * 1e-9);
    let copy = rates.copy * 1e-9;
    format!(
        "GB/s: copy {copy:.1}, dependent loads {}\n\
         G/s: flop {flop:.1}, exp {exp:.2}, divide {divide:.2}, integer {integer:.1}, shared {shared:.2}, atomic {atomic:.3}\n",
        loads.join(", ")
    )
}

fn cells(stage: &Stage) -> Vec<String> {
    let mut cells = vec![stage.stage.clone(), format!("{:.3}", stage.ms)];
    cells.push(stage.model_ms.map_or("-".into(), |ms| format!("{ms:.3}")));
    match stage.bounds {
        Some(bounds) => {
            let ([memory, arithmetic], b) = (bounds.work(), bounds);
            let shares = [memory, arithmetic, b.launches + b.barriers, b.misses, b.waits];
            cells.push(bounds.largest().into());
            cells.extend(shares.map(|share| format!("{:.0}", 100.0 * share)));
        }
        None => cells.extend(["-"; SHARES + 1].map(String::from)),
    }
    cells.push(stage.lanes.map_or("-".into(), |lanes| format!("{lanes:.1}")));
    cells.push(format!("{:.1}", stage.creation_ms));
    // Adding 0 drops the sign of a difference that rounds to -0.
    cells.push(stage.first_run_ms.map_or("-".into(), |ms| format!("{:.1}", (10.0 * ms).round() / 10.0 + 0.0)));
    cells
}
