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
    report.to_string()
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
