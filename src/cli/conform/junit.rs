//! `--junit`: results as build servers read them. A suite is a device, a case a stage of a fixture.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Property, Report, SerializeError, TestCase, TestCaseStatus, TestSuite};

use super::expect::Known;
use milkglass::measure::results::{Outcome, Results, Verdict};

/// The text of the file.
pub(super) fn report(all: &Results, known: &[Known]) -> Result<String, SerializeError> {
    let mut report = Report::new("milkglass conform");
    for facts in &all.run.devices {
        let mut suite = TestSuite::new(format!("{}, {}", facts.name, facts.driver));
        let properties = [
            ("command", all.run.command.clone()),
            ("version", all.run.version.clone()),
            ("commit", all.run.commit.clone().unwrap_or_default()),
            ("system", all.run.system.clone()),
            ("validation_layer", all.run.layer.clone().unwrap_or_default()),
            ("date", all.run.date.clone()),
            ("vendor_id", format!("{:#06x}", facts.vendor_id)),
            ("device_id", format!("{:#06x}", facts.device_id)),
            ("driver_version", facts.driver_version.to_string()),
        ];
        for (key, value) in properties {
            suite.add_property(Property::new(key, value));
        }
        suite.add_test_cases(all.results.iter().filter(|outcome| outcome.device == facts.name).map(case));
        report.add_test_suite(suite);
    }
    let stale: Vec<String> = known.iter().filter_map(|known| known.stale(all)).collect();
    if !stale.is_empty() {
        let mut suite = TestSuite::new("expectations");
        suite.add_test_cases(stale.into_iter().map(|what| {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message("a known failure is gone");
            TestCase::new(what, status)
        }));
        report.add_test_suite(suite);
    }
    Ok(known_root(&report.to_string()?, report.skipped))
}

/// The text without the attribute `skipped` of `testsuites`: the schema of Jenkins' xUnit plugin has it for each suite,
/// and refuses a file that also has it for all of them.
pub(in crate::cli) fn known_root(text: &str, skipped: usize) -> String {
    // A value's `>` and quotes are escaped.
    let end = text.find("<testsuites").and_then(|at| Some(at + text[at..].find('>')?));
    let (root, rest) = text.split_at(end.unwrap_or(0));
    format!("{}{rest}", root.replacen(&format!(" skipped=\"{skipped}\""), "", 1))
}

fn case(outcome: &Outcome) -> TestCase {
    let status = match (&outcome.known, outcome.verdict) {
        (_, Verdict::Conforms) => TestCaseStatus::success(),
        (Some(why), verdict) => {
            let mut status = TestCaseStatus::skipped();
            status.set_message(format!("known: {}, {why}", verdict.name()));
            status
        }
        (None, verdict) => {
            let differs = verdict == Verdict::Differs;
            let kind = if differs { NonSuccessKind::Failure } else { NonSuccessKind::Error };
            let mut status = TestCaseStatus::non_success(kind);
            status.set_message(outcome.faults.first().cloned().unwrap_or_default());
            status.set_type(verdict.name().to_lowercase());
            status.set_description(format!("{}\nrepeat: {}", outcome.faults.join("\n"), outcome.repeat));
            status
        }
    };
    let mut case = TestCase::new(if outcome.stage.is_empty() { "-" } else { &outcome.stage }, status);
    case.set_classname(outcome.fixture.clone());
    case.set_time(Duration::from_secs_f64(outcome.seconds.clamp(0.0, 1e9)));
    case
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::measure::results::DeviceFacts;

    /// The names of a tag's attributes.
    fn attributes<'a>(text: &'a str, tag: &str) -> Vec<&'a str> {
        let from = text.find(&format!("<{tag} ")).unwrap();
        let tag = text[from..].split('>').next().unwrap();
        tag.split("=\"").filter_map(|part| part.rsplit(' ').next()).filter(|name| !name.ends_with('"')).collect()
    }

    #[test]
    fn the_root_has_what_the_schema_of_jenkins_knows() {
        let mut all = Results::default();
        all.run.devices.push(DeviceFacts { name: "a > b \" skipped=\"1\"".into(), ..DeviceFacts::default() });
        let (device, known) = (all.run.devices[0].name.clone(), Some("bug 7".to_string()));
        let verdict = Verdict::Differs;
        all.results.push(Outcome { device, stage: "push".into(), verdict, known, ..Outcome::default() });
        let text = report(&all, &[]).unwrap();
        assert_eq!(attributes(&text, "testsuites"), ["name", "tests", "failures", "errors"], "{text}");
        assert_eq!(attributes(&text, "testsuite"), ["name", "tests", "skipped", "errors", "failures"], "{text}");
        assert!(
            text.contains("<testsuite name=\"a &gt; b &quot; skipped=&quot;1&quot;, \" tests=\"1\" skipped=\"1\""),
            "{text}"
        );
        assert_eq!(text.matches("<testcase ").count(), 1, "{text}");
    }
}
