//! Tables of what compilers report, and what is worse than before.

use std::path::Path;

use super::record::{Compiled, Pipeline, Sheets};
use milkglass::error::{Input, Result};
use milkglass::measure::table::Table;

/// What a table shows of what drivers report, if they do: heading, meaning, and names of RADV and NVK.
const SHOWN: [(&str, &str, &[&str]); 9] = [
    ("registers", "vector registers of an invocation", &["VGPRs", "Number of GPRs", "Register Count"]),
    ("scalar", "scalar registers of a wave", &["SGPRs"]),
    ("spilled", "registers kept in memory", &["Spilled VGPRs", "Spills to memory", "Number of spills to memory"]),
    ("scratch", "memory for arrays and spills, bytes", &["Scratch size", "Scratch size per thread", "SLM size"]),
    ("shared", "shared memory of a group, bytes", &["LDS size", "LDS Size", "Shared memory size"]),
    ("waves", "waves that a SIMD unit holds at once", &["Subgroups per SIMD"]),
    ("code, B", "instructions, bytes", &["Code size", "Code Size"]),
    ("latency", "cycles of a wave alone; the compiler's estimate, loops counted as if run a few times", &["Latency"]),
    ("cycles", "cycles a wave among many; likewise", &["Inverse Throughput"]),
];
/// Columns in which more is worse than in a baseline, and by which factor; the waves are the other way round.
const WORSE: [(&str, f64); 3] = [("spilled", 1.0), ("scratch", 1.0), ("cycles", 1.1)];

/// The value of a column.
fn value(pipeline: &Pipeline, heading: &str) -> Option<f64> {
    let (.., names) = SHOWN.iter().find(|(known, ..)| *known == heading)?;
    pipeline.statistics.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, value)| *value)
}

/// The pipelines of a compiler as a table, those that take most cycles first.
pub(super) fn table_of(pipelines: &[Pipeline]) -> Table {
    let reported = |heading: &str| pipelines.iter().any(|pipeline| value(pipeline, heading).is_some());
    let shown: Vec<(&str, &str)> =
        SHOWN.iter().map(|(heading, meaning, _)| (*heading, *meaning)).filter(|(h, _)| reported(h)).collect();
    let mut order: Vec<&Pipeline> = pipelines.iter().collect();
    let weight = |pipeline: &Pipeline| value(pipeline, "cycles").or(value(pipeline, "code, B")).unwrap_or(0.0);
    order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let row = |pipeline: &&Pipeline| {
        let values = shown.iter().map(|(heading, _)| value(pipeline, heading).map_or("-".into(), |x| format!("{x}")));
        let rest = [format!("{:.0}", pipeline.milliseconds), pipeline.constants.clone()];
        [pipeline.kernel.clone()].into_iter().chain(values).chain(rest).collect()
    };
    let ends = [("ms", "time to compile"), ("specialization constants", "")];
    let columns = [&[("kernel", "")], shown.as_slice(), &ends].concat();
    Table::new(columns, order.iter().map(row).collect())
}

/// What kernels that replace built-in ones change, a line each; empty where none does.
pub(super) fn changes(compiled: &Compiled) -> String {
    let mut text = String::new();
    for old in &compiled.built_in {
        let same = |new: &&Pipeline| new.kernel == old.kernel && new.constants == old.constants;
        let Some(new) = compiled.pipelines.iter().find(same) else { continue };
        let changed: Vec<String> = SHOWN
            .iter()
            .filter_map(|(heading, ..)| {
                let (x, y) = (value(old, heading)?, value(new, heading)?);
                let share = if x > 0.0 { format!(" ({:+.1} %)", 100.0 * (y / x - 1.0)) } else { String::new() };
                (x != y).then(|| format!("{heading} {x} -> {y}{share}"))
            })
            .collect();
        let changed = if changed.is_empty() { "nothing that is reported changes".into() } else { changed.join(", ") };
        text += &format!("{} [{}], built-in -> yours: {changed}\n", old.kernel, old.constants);
    }
    text
}

/// A line for each family of which the baseline lacks pipelines; an error if it has none of them.
pub(super) fn unknown(before: &Sheets, now: &Sheets, path: &Path) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    for (family, sheet) in now {
        let old = before.get(family).map_or(&[][..], |sheet| &sheet.pipelines);
        let known = |new: &&Pipeline| old.iter().any(|old| old.kernel == new.kernel && old.constants == new.constants);
        let (all, known) = (sheet.pipelines.len(), sheet.pipelines.iter().filter(known).count());
        if known == 0 && all > 0 {
            let fault = Input::new("the baseline has no pipeline that was compiled").file(path).key("--baseline");
            return Err(fault.found(family).expected("a file of --csv, of this scene and family").into());
        }
        if known < all {
            lines.push(format!("{family}: {} of {all} pipelines are not in the baseline", all - known));
        }
    }
    Ok(lines)
}

/// What is worse than it was, of the pipelines that both have.
pub(super) fn worse(before: &Sheets, now: &Sheets) -> Vec<String> {
    let mut found = Vec::new();
    let every = now.iter().flat_map(|(family, sheet)| sheet.pipelines.iter().map(move |new| (family, new)));
    for (family, new) in every {
        let same = |old: &&Pipeline| old.kernel == new.kernel && old.constants == new.constants;
        let Some(old) = before.get(family).and_then(|sheet| sheet.pipelines.iter().find(same)) else { continue };
        let mut add = |heading: &str, is_worse: &dyn Fn(f64, f64) -> bool| {
            if let (Some(x), Some(y)) = (value(old, heading), value(new, heading))
                && is_worse(x, y)
            {
                found.push(format!("{family}: {} [{}]: {heading} {x} -> {y}", new.kernel, new.constants));
            }
        };
        for (heading, factor) in WORSE {
            add(heading, &|x, y| y > factor * x);
        }
        add("waves", &|x, y| y < x);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::file;
    use super::*;

    fn pipeline(statistics: &[(&str, f64)]) -> Pipeline {
        let statistics = statistics.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        let (kernel, constants) = ("a/b".to_string(), "N = 1, M = 2".to_string());
        Pipeline { kernel, constants, milliseconds: 0.0, statistics }
    }

    fn sheets(statistics: &[(&str, f64)]) -> Sheets {
        let compiled = Compiled { pipelines: vec![pipeline(statistics)], ..Compiled::default() };
        [("navi21".to_string(), compiled)].into()
    }

    #[test]
    fn what_is_worse_is_named_and_files_hold_what_was_reported() {
        let old = sheets(&[("Spilled VGPRs", 0.0), ("Subgroups per SIMD", 8.0), ("Inverse Throughput", 100.0)]);
        assert!(worse(&old, &sheets(&[("Spilled VGPRs", 0.0), ("Inverse Throughput", 109.0)])).is_empty());
        let new = sheets(&[("Spilled VGPRs", 3.0), ("Subgroups per SIMD", 7.0), ("Inverse Throughput", 111.0)]);
        assert_eq!(
            worse(&old, &new),
            ["spilled 0 -> 3", "cycles 100 -> 111", "waves 8 -> 7"]
                .map(|what| format!("navi21: a/b [N = 1, M = 2]: {what}"))
        );
        assert!(worse(&new, &old).is_empty());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, file::csv(&new).unwrap()).unwrap();
        assert_eq!(file::read(&path).unwrap(), new);
        std::fs::write(&path, "compiler,kernel\na,b\n").unwrap();
        assert!(file::read(&path).unwrap_err().to_string().contains("not what compile writes"));
    }

    #[test]
    fn what_a_replaced_kernel_changes_is_told() {
        let old = pipeline(&[("VGPRs", 40.0), ("Scratch size", 0.0), ("Latency", 7.0)]);
        let new = pipeline(&[("VGPRs", 50.0), ("Scratch size", 64.0), ("Latency", 7.0)]);
        let compiled = Compiled { pipelines: vec![new], built_in: vec![old.clone()], ..Compiled::default() };
        let line = "a/b [N = 1, M = 2], built-in -> yours: registers 40 -> 50 (+25.0 %), scratch 0 -> 64\n";
        assert_eq!(changes(&compiled), line);
        let same = Compiled { pipelines: vec![old.clone()], built_in: vec![old], ..Compiled::default() };
        assert!(changes(&same).ends_with("nothing that is reported changes\n"));
    }
}
