//! `--junit`: what limits were held to, as build servers read it. A suite is a comparison, a case a row of it.

use std::path::Path;

use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};

use super::gate::Held;
use crate::cli::conform::known_root;
use crate::cli::write;
use milkglass::error::{Input, Result};

/// Writes the file; `properties` say what was timed, and where.
pub(super) fn put(path: &Path, held: &[Held], properties: &[(&str, String)]) -> Result<()> {
    let mut report = Report::new("milkglass profile");
    let mut suites: Vec<&str> = held.iter().map(|held| held.suite.as_str()).collect();
    suites.dedup();
    for name in suites {
        let mut suite = TestSuite::new(name);
        for (key, value) in properties {
            suite.add_property(Property::new(*key, value.clone()));
        }
        suite.add_test_cases(held.iter().filter(|held| held.suite == name).map(case));
        report.add_test_suite(suite);
    }
    let fault = |error| Input::new(format!("could not be written: {error}")).file(path);
    let text = report.to_string().map_err(fault)?;
    write(path, known_root(&text, report.skipped))
}

fn case(held: &Held) -> TestCase {
    let mut case = match &held.failure {
        None => TestCase::new(held.name.as_str(), TestCaseStatus::success()),
        Some(failure) => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(failure.as_str());
            TestCase::new(held.name.as_str(), status)
        }
    };
    case.set_classname(held.suite.as_str());
    case.set_system_out(held.found.as_str());
    case
}
