//! Comparisons in processes of their own, one a fixture and device: a hang or a crash ends one of them.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use super::alone::failure;
use super::arguments::{Arguments, repeating};
use super::choose::Choice;
use super::sink::Sink;
use crate::cli::stop;
use crate::cli::text::last_error;
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Adapter;
use milkglass::measure::probe::{FIXTURE, REPEAT};
use milkglass::measure::results::{DeviceFacts, Line, Outcome, Verdict};

/// Compares everything that was chosen on all devices.
pub(super) fn run(
    arguments: &Arguments,
    choices: &[Choice],
    devices: &[(usize, &Adapter)],
    sink: &mut Sink,
) -> Result<()> {
    for choice in choices {
        for (index, adapter) in devices {
            one(arguments, choice, (*index, adapter), sink)?;
        }
    }
    Ok(())
}

/// The command of a child on this device.
fn command(arguments: &Arguments, device: usize) -> Result<Command> {
    let exe = std::env::current_exe().map_err(|error| Error::device("starting a process for a fixture", error))?;
    let mut command = Command::new(exe);
    command.arg("conform").arg("--child").args(["--device", &device.to_string()]);
    if arguments.no_validation {
        command.arg("--no-validation");
    }
    command.args(arguments.replace.pairs().iter().flat_map(|pair| ["--replace", pair]));
    Ok(command)
}

/// What is compared, as arguments.
fn compares(command: &mut Command, arguments: &Arguments, choice: &Choice) {
    match choice {
        Choice::Fixture(name) => {
            command.args(["--fixture", name]);
        }
        Choice::Scene(name) => {
            command.arg(name).arg(format!("--frame={}", arguments.frame));
            command.args(arguments.sets.iter().flat_map(|set| ["--set", set]));
            command.args(arguments.option_args.words());
        }
    }
    if !arguments.stage.is_empty() {
        command.args(["--stage", &arguments.stage.join(",")]);
    }
    if let Some(folder) = &arguments.dump {
        command.arg("--dump").arg(folder);
        if arguments.minimize {
            command.arg("--minimize");
        }
    }
    command.args(arguments.memory.words());
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

/// Probes a device in a process of its own; what came of it where it did not end.
pub(super) fn probed(
    arguments: &Arguments,
    (index, adapter): (usize, &Adapter),
    facts: &mut DeviceFacts,
) -> Result<Option<Outcome>> {
    let mut child = command(arguments, index)?;
    child.arg("--probe-only");
    let ended = watched(child, arguments.timeout, &mut |line| {
        if let Line::Run(run) = line {
            facts.probes = run.devices.into_iter().next().map(|device| device.probes).unwrap_or_default();
        }
        Ok(())
    })?;
    let outcome = |(verdict, why): (Verdict, String)| Outcome {
        repeat: REPEAT.into(),
        ..failure(arguments, adapter, (FIXTURE, ""), verdict, &why)
    };
    Ok(ended.map(outcome))
}

fn one(arguments: &Arguments, choice: &Choice, (index, adapter): (usize, &Adapter), sink: &mut Sink) -> Result<()> {
    let mut child = command(arguments, index)?;
    compares(&mut child, arguments, choice);
    let mut stage = String::new();
    let ended = watched(child, arguments.timeout, &mut |line| match line {
        Line::Begins(_, begun) => {
            stage.clone_from(&begun);
            sink.begins(choice.name(), &begun)
        }
        // What ended is over; a device that failed has said so itself.
        Line::Result(outcome) if outcome.verdict == Verdict::DeviceFailed => Ok(()),
        Line::Result(mut outcome) => {
            if !arguments.scenes.is_empty() {
                outcome.repeat = repeating(arguments, &outcome);
            }
            stage.clear();
            sink.add(*outcome)
        }
        Line::Run(_) => Ok(()),
    })?;
    match ended {
        Some((verdict, why)) => sink.add(failure(arguments, adapter, (choice.name(), &stage), verdict, &why)),
        None => Ok(()),
    }
}

/// Runs a child to its end, or to that of its time; what came of it where it did not end well. `heard` takes each line
/// as it comes.
fn watched(
    mut command: Command,
    timeout: f64,
    heard: &mut dyn FnMut(Line) -> Result<()>,
) -> Result<Option<(Verdict, String)>> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| Error::device("starting a process for a fixture", error))?;
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
    // One that has closed its output may still hang.
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
