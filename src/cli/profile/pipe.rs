//! Another build of this program as a variant: a process that runs a frame whenever a line on its standard input asks
//! for one, and answers with a line of JSON. Both builds run like this, so that neither has an advantage.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread::JoinHandle;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::arguments::Arguments;
use super::described;
use crate::cli::text::last_error;
use crate::cli::{check_messages, print};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, Timing};
use milkglass::measure::profile::{Settings, result, variant};
use milkglass::measure::rounds::{Frame, Variant};
use milkglass::scene::Scene;

/// The version of the exchange.
const SCHEMA: u32 = 1;
/// The line that asks for a frame.
const ASK: &str = "frame\n";

/// What a process says once it is ready.
#[derive(Serialize, Deserialize)]
pub(super) struct Hello {
    /// The version of the exchange.
    rounds: u32,
    version: String,
    commit: Option<String>,
    pub device: String,
    pub driver: String,
    /// The result of a frame, in base 64.
    result: String,
}

/// What the process says of a frame.
#[derive(Serialize, Deserialize)]
struct Answer {
    /// Milliseconds from call to result.
    wall: f64,
    /// Steps and milliseconds; none without timestamps.
    steps: Vec<(String, Option<f64>)>,
}

/// Runs frames until standard input ends.
pub(super) fn serve(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<()> {
    let mut own = variant(scene, device, settings)?;
    let [name, driver] = described(device);
    say(&Hello {
        rounds: SCHEMA,
        version: env!("CARGO_PKG_VERSION").into(),
        commit: option_env!("MILKGLASS_COMMIT").map(String::from),
        device: name.into(),
        driver: driver.into(),
        result: STANDARD.encode(result(&mut own.session)?),
    })?;
    for line in std::io::stdin().lines() {
        match line {
            Ok(line) if line == ASK.trim_end() => {}
            _ => break,
        }
        let frame = own.frame()?;
        let finite = |ms: f64| Some(ms).filter(|ms| ms.is_finite());
        let steps = frame.steps.into_iter().map(|step| (step.name, finite(step.milliseconds))).collect();
        say(&Answer { wall: frame.wall, steps })?;
    }
    check_messages(device)
}

fn say(what: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string(what).map_err(|error| Error::from(Input::new(error.to_string())))?;
    print(&(text + "\n"))
}

/// A process that serves frames.
pub(super) struct Other {
    program: String,
    child: Child,
    asks: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    errors: Option<JoinHandle<String>>,
    pub(super) hello: Hello,
    result: Vec<u8>,
}

impl Other {
    /// Starts a program and waits until it is ready.
    pub(super) fn start(program: &Path, arguments: &Arguments) -> Result<Self> {
        let fault = |what: String| {
            let fault = Input::new(what).key("--against").found(program.display());
            Error::from(fault.expected("a milkglass that has `profile --against`"))
        };
        let mut command = Command::new(program);
        command.arg("profile").args(arguments.words()).arg("--serve");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child =
            command.spawn().map_err(|error| fault(format!("this program could not be started: {error}")))?;
        let asks = child.stdin.take();
        let (Some(out), Some(mut err)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(fault("this program has no output".into()));
        };
        let errors = std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = err.read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        });
        let hello = Hello {
            rounds: 0,
            version: String::new(),
            commit: None,
            device: String::new(),
            driver: String::new(),
            result: String::new(),
        };
        let (program, answers) = (program.display().to_string(), BufReader::new(out));
        let mut other = Self { program, child, asks, answers, errors: Some(errors), hello, result: Vec::new() };
        let Some(line) = other.line() else {
            let said = other.ended();
            return Err(fault(format!("this program has no `profile --serve`{}", after(&said))));
        };
        other.hello = match serde_json::from_str(&line) {
            Ok(hello @ Hello { rounds: SCHEMA, .. }) => hello,
            _ => return Err(fault("this program has no `profile --serve` of this version".into())),
        };
        let result = STANDARD.decode(&other.hello.result);
        other.result = result.map_err(|error| fault(format!("this program's result could not be read: {error}")))?;
        Ok(other)
    }

    /// The program's version and commit, its device and its driver, in a line.
    pub(super) fn origin(&self) -> String {
        let Hello { version, commit, device, driver, .. } = &self.hello;
        let commit = commit.as_deref().map(|commit| format!(", commit {}", commit.get(..12).unwrap_or(commit)));
        format!("milkglass {version}{}, {device}, {driver}", commit.unwrap_or_default())
    }

    /// The result of its first frame.
    pub(super) fn result(&self) -> &[u8] {
        &self.result
    }

    /// The next line that it says; `None` once it has ended.
    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        self.answers.read_line(&mut line).ok().filter(|count| *count > 0).map(|_| line)
    }

    /// Waits for its end; returns the last error that it wrote.
    fn ended(&mut self) -> String {
        self.asks = None;
        let _ = self.child.wait();
        self.errors.take().and_then(|errors| errors.join().ok()).map_or_else(String::new, |said| last_error(&said))
    }
}

fn after(said: &str) -> String {
    if said.is_empty() { String::new() } else { format!(": it says: {said}") }
}

impl Variant for Other {
    fn process(&self) -> u32 {
        self.child.id()
    }

    fn frame(&mut self) -> Result<Frame> {
        let asked = self.asks.as_mut().is_some_and(|asks| asks.write_all(ASK.as_bytes()).is_ok());
        let line = if asked { self.line() } else { None };
        let Some(answer) = line.and_then(|line| serde_json::from_str::<Answer>(&line).ok()) else {
            let _ = self.child.kill();
            let said = self.ended();
            return Err(Error::device("timing another build", format!("{} ended{}", self.program, after(&said))));
        };
        let step = |(name, ms): (String, Option<f64>)| Timing {
            name,
            milliseconds: ms.unwrap_or(f64::NAN),
            start: f64::NAN,
            ..Timing::default()
        };
        let steps = answer.steps.into_iter().map(step).collect();
        Ok(Frame { wall: answer.wall, steps, ..Frame::default() })
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        // A process that is ready ends with its input; any other one is not waited for.
        self.asks = None;
        if self.hello.rounds != SCHEMA {
            let _ = self.child.kill();
        }
        let _ = self.child.wait();
    }
}
