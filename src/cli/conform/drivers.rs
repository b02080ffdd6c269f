//! Several devices beside each other: a row a stage, a column a driver.

use super::sheet::of_tolerance;
use crate::cli::table;
use milkglass::measure::results::{DeviceFacts, Outcome, Results, Verdict};

/// The table, of probes and stages; nothing for one device.
pub(super) fn side_by_side(all: &Results) -> String {
    let devices = &all.run.devices;
    if devices.len() < 2 {
        return String::new();
    }
    let mut header = vec!["stage".to_string()];
    header.extend(devices.iter().map(|device| device.name.clone()));
    let mut rows: Vec<Vec<String>> = Vec::new();
    for fact in &devices[0].probes {
        let cell = |device: &DeviceFacts| match device.probes.iter().find(|own| own.name == fact.name) {
            Some(own) if own.right => "right".to_string(),
            Some(own) if own.needed => "WRONG".into(),
            Some(_) => "wrong, avoided".into(),
            None => "-".into(),
        };
        let name = format!("probe {}", fact.name);
        rows.push([name].into_iter().chain(devices.iter().map(cell)).collect());
    }
    let mut stages: Vec<&str> = Vec::new();
    for outcome in all.results.iter().filter(|outcome| outcome.words > 0 || !outcome.verdict.passes()) {
        if !stages.contains(&outcome.stage.as_str()) {
            stages.push(&outcome.stage);
        }
    }
    for stage in stages {
        let cell = |device: &DeviceFacts| {
            let own = |outcome: &&Outcome| {
                outcome.stage == stage && outcome.device == device.name && outcome.driver == device.driver
            };
            cell(&all.results.iter().filter(own).collect::<Vec<_>>())
        };
        let name = if stage.is_empty() { "(no stage had begun)" } else { stage };
        rows.push([name.to_string()].into_iter().chain(devices.iter().map(cell)).collect());
    }
    let text = "by stage and driver: the largest share of the tolerance that is used, or what is wrong in how many \
                fixtures\n";
    format!("{text}{}\n", table(header.iter().map(String::as_str), rows))
}

/// What the comparisons of a stage on a device come to.
fn cell(own: &[&Outcome]) -> String {
    let wrong: Vec<&&Outcome> = own.iter().filter(|outcome| !outcome.verdict.passes()).collect();
    if own.is_empty() {
        return "-".into();
    }
    if wrong.is_empty() {
        let largest = own.iter().map(|outcome| outcome.of_tolerance.unwrap_or(f64::NAN)).fold(0.0, f64::max);
        return of_tolerance(Some(largest));
    }
    let mut kinds: Vec<(Verdict, usize)> = Vec::new();
    for outcome in &wrong {
        match kinds.iter_mut().find(|(kind, _)| *kind == outcome.verdict) {
            Some((_, count)) => *count += 1,
            None => kinds.push((outcome.verdict, 1)),
        }
    }
    let kinds: Vec<String> = kinds.iter().map(|(kind, count)| format!("{} {count}", kind.name())).collect();
    let known = if wrong.iter().all(|outcome| outcome.known.is_some()) { " (known)" } else { "" };
    format!("{} of {}{known}", kinds.join(", "), own.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::measure::probe::Fact;

    #[test]
    fn each_driver_has_a_column() {
        let fact = |right| Fact { name: "rounding".into(), right, needed: true, ..Fact::default() };
        let device = |driver: &str, right| DeviceFacts {
            name: format!("device {driver}"),
            driver: driver.into(),
            probes: vec![fact(right)],
            ..DeviceFacts::default()
        };
        let outcome = |driver: &str, fixture: &str, verdict| Outcome {
            device: format!("device {driver}"),
            driver: driver.into(),
            fixture: fixture.into(),
            stage: "push".into(),
            words: 1,
            of_tolerance: Some(0.25),
            verdict,
            ..Outcome::default()
        };
        let mut all = Results::default();
        all.run.devices = vec![device("a", true), device("b", false)];
        all.results = vec![
            outcome("a", "x", Verdict::Conforms),
            outcome("b", "x", Verdict::Differs),
            outcome("a", "y", Verdict::Conforms),
            outcome("b", "y", Verdict::Conforms),
            outcome("b", "z", Verdict::Hung),
        ];
        let text = side_by_side(&all);
        let cells =
            |line: &str| line.split("  ").filter(|c| !c.is_empty()).map(str::trim).collect::<Vec<_>>().join("|");
        let lines: Vec<String> = text.lines().skip(1).filter(|line| !line.is_empty()).map(cells).collect();
        let expected = ["stage|device a|device b", "probe rounding|right|WRONG", "push|25 %|DIFFERS 1, HUNG 1 of 3"];
        assert_eq!(lines, expected, "{text}");
        all.run.devices.truncate(1);
        assert_eq!(side_by_side(&all), "");
    }
}
