//! Reading results: a JSON object, or lines of JSON of which the last may have been cut off.

use std::path::Path;

use super::{Line, Results, SCHEMA};
use crate::error::{Error, Input, Result};

/// Most bytes of a file of results.
const MOST: u64 = 1 << 30;

/// The results of a file that `conform --json` or `conform --jsonl` wrote.
pub fn read(path: &Path) -> Result<Results> {
    let fault = |what: String| Error::from(Input::new(what).file(path));
    let known = std::fs::metadata(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    if !known.is_file() || known.len() > MOST {
        return Err(fault(format!("not a plain file of at most {MOST} bytes")));
    }
    let text = std::fs::read_to_string(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    let found = parse(&text).map_err(|(line, what)| {
        let expected = "what `milkglass conform --json` or `--jsonl` writes";
        Error::from(Input::new(what).file(path).line(line).expected(expected))
    })?;
    if found.run.schema != SCHEMA {
        let fault = Input::new("this version of the format is not known").file(path).key("schema");
        return Err(fault.found(found.run.schema).expected(SCHEMA).into());
    }
    Ok(found)
}

/// The results, or line and fault.
fn parse(text: &str) -> std::result::Result<Results, (usize, String)> {
    let explained = |error: serde_json::Error, line: usize| {
        let what = error.to_string();
        (line, what.rsplit_once(" at line ").map_or(what.as_str(), |(what, _)| what).to_string())
    };
    let mut lines = text.lines().enumerate();
    let first = lines.next().map(|(_, line)| serde_json::from_str::<Line>(line));
    let Some(Ok(Line::Run(run))) = first else {
        return serde_json::from_str(text).map_err(|error| {
            let line = error.line();
            explained(error, line)
        });
    };
    let mut found = Results { run, ..Results::default() };
    for (index, line) in lines {
        match serde_json::from_str(line) {
            Ok(Line::Result(outcome)) => found.results.push(*outcome),
            Ok(Line::Begins(..)) => {}
            Ok(Line::Run(_)) => return Err((index + 1, "a second run".into())),
            // A killed run leaves a part of a line at its end.
            Err(_) if !text.ends_with('\n') && index + 1 == text.lines().count() => {}
            Err(error) => return Err(explained(error, index + 1)),
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::results::{Outcome, Run};

    #[test]
    fn both_forms_are_read_and_a_cut_line_is_left_out() {
        let run = Run { schema: SCHEMA, version: "1".into(), ..Run::default() };
        let outcome = Outcome { stage: "shade".into(), words: 3, of_tolerance: Some(0.5), ..Outcome::default() };
        let whole = Results { run: run.clone(), results: vec![outcome.clone(), outcome.clone()] };
        let object = serde_json::to_string_pretty(&whole).unwrap();
        assert_eq!(parse(&object).unwrap(), whole);
        let line = |line: &Line| serde_json::to_string(line).unwrap() + "\n";
        let begins = Line::Begins("a".into(), "b".into());
        let result = Line::Result(Box::new(outcome));
        let lines = [line(&Line::Run(run)), line(&begins), line(&result), line(&result)].concat();
        assert_eq!(parse(&lines).unwrap(), whole);
        assert_eq!(parse(&lines[..lines.len() - 20]).unwrap().results.len(), 1);
        assert_eq!(parse(&lines.replacen("\"words\":3", "\"words\":-3", 1)).unwrap_err().0, 3);
        assert_eq!(parse("[]").unwrap_err().0, 1);
        assert_eq!(parse("").unwrap_err().0, 1);
    }
}
