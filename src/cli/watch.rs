//! Work in a process of its own: a hang or a crash ends that process only.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;

use super::stop;
use super::text::last_error;
use milkglass::error::{Error, Input, Result};
use milkglass::measure::results::Verdict;

/// What an error says was being done.
const STARTS: &str = "starting a process of its own";

/// Parses a time limit, in seconds.
pub(super) fn seconds(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|seconds| (0.001..=1e6).contains(seconds));
    found.ok_or_else(|| "expected 0.001 to 1e6 seconds".into())
}

/// A command of this program for a child.
pub(super) fn itself(command: &str) -> Result<Command> {
    let mut child = Command::new(std::env::current_exe().map_err(|error| Error::device(STARTS, error))?);
    child.args([command, "--child"]);
    Ok(child)
}

/// What a child says on standard output, line by line; its end is the end of the channel.
fn lines(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(out) = child.stdout.take() {
        std::thread::spawn(move || {
            // A line that can't be read is the last one.
            for line in BufReader::new(out).lines().map_while(std::result::Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
    }
    receiver
}

/// Runs a child, and kills it after `timeout` seconds; returns its failure if it did not end well. `heard` takes each
/// line of JSON as it comes; other lines are shown.
pub(super) fn watched<L: DeserializeOwned>(
    mut command: Command,
    timeout: f64,
    heard: &mut dyn FnMut(L) -> Result<()>,
) -> Result<Option<(Verdict, String)>> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| Error::device(STARTS, error))?;
    let end = Instant::now() + Duration::from_secs_f64(timeout);
    let out = lines(&mut child);
    let err = child.stderr.take().map(|mut err| {
        std::thread::spawn(move || {
            let mut text = Vec::new();
            let _ = err.read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        })
    });
    stop::guard(child);
    let mut told = Ok(());
    let hung = loop {
        match out.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(line) => told = heard(line),
                Err(_) => tell!("{line}"),
            },
            Err(RecvTimeoutError::Disconnected) => break false,
            Err(RecvTimeoutError::Timeout) => break true,
        }
        if told.is_err() {
            break false;
        }
    };
    if hung || told.is_err() {
        stop::kill();
    }
    // A child that has closed its output may still hang.
    let status = stop::wait(end);
    told?;
    let said = match &err {
        Some(thread) if !thread.is_finished() && status.is_none() => String::new(),
        _ => err.and_then(|thread| thread.join().ok()).unwrap_or_default(),
    };
    let late = || (Verdict::Hung, format!("it did not end within {timeout} s and was killed"));
    let Some(status) = status.filter(|_| !hung) else { return Ok(Some(late())) };
    Ok(Some(match status.code() {
        Some(0) => {
            said.lines().for_each(|line| tell!("{line}"));
            return Ok(None);
        }
        Some(2) => return Err(Input::new(last_error(&said)).into()),
        Some(3) => (Verdict::DeviceFailed, last_error(&said)),
        _ => (Verdict::Crashed, format!("{}{}", ended(status), after(&last_error(&said)))),
    }))
}

fn after(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!(": {text}") }
}

/// How a process ended.
fn ended(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("signal {signal} ended it");
    }
    format!("it ended with {status}")
}
