//! A case as an AmberScript, the format of tests of the Vulkan conformance suite.
//!
//! Amber compares whole buffers bit for bit, or values of a buffer by its type. Words that must agree bit for bit are
//! compared as integers; those with a tolerance as floats, in a second run on copies of the buffers of that type.

use std::fmt::Write as _;

use super::files::modules;
use super::{ANY, BITS, Case, Part};
use crate::gpu::set_by_device;

/// Values in a line.
const VALUES: usize = 12;

/// How words are read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Bits,
    Floats,
}

impl Type {
    fn name(self) -> &'static str {
        if self == Self::Bits { "uint32" } else { "float" }
    }

    /// The ending of the names of buffers and pipelines.
    fn ending(self) -> &'static str {
        if self == Self::Bits { "" } else { "_f" }
    }
}

/// The script, which has to lie beside the files of the case.
#[must_use]
pub fn script(case: &Case) -> String {
    let mut text = head(case);
    let names = modules(case);
    let mut declared: Vec<&String> = Vec::new();
    for name in &names {
        if !declared.contains(&name) {
            let _ = writeln!(text, "SHADER compute {name} SPIRV-BIN FILE {name}.spv");
            declared.push(name);
        }
    }
    text.push('\n');
    let loose = |part: &Part| part.allowed.iter().any(|allowed| *allowed >= 0.0);
    let floats = (0..case.buffers.len()).any(|b| case.writes(b) && loose(&case.buffers[b]));
    let types: &[Type] = if floats { &[Type::Bits, Type::Floats] } else { &[Type::Bits] };
    for &kind in types {
        buffers(&mut text, case, kind);
    }
    for (k, dispatch) in case.dispatches.iter().enumerate().filter(|(_, dispatch)| !dispatch.push.is_empty()) {
        let _ = writeln!(text, "BUFFER push{k} DATA_TYPE uint32 DATA\n {}\nEND", listed(&dispatch.push));
    }
    for &kind in types {
        pipelines(&mut text, case, kind, &names);
    }
    for &kind in types {
        text.push('\n');
        for (k, dispatch) in case.dispatches.iter().enumerate() {
            let [x, y, z] = dispatch.groups;
            let _ = writeln!(text, "RUN run{k}{} {x} {y} {z}", kind.ending());
        }
    }
    text.push('\n');
    for (_, part) in case.buffers.iter().enumerate().filter(|(b, _)| case.writes(*b)) {
        expectations(&mut text, part);
    }
    text
}

/// What the case is about, and how long a run may take.
fn head(case: &Case) -> String {
    let mut text = String::from("#!amber\n");
    let about = &case.about;
    for (key, value) in [
        ("stage", format!("{}: {}", about.stage, about.does)),
        ("step", format!("{}, {}", about.step, about.dispatches)),
        ("from", format!("{}, on {}, {}", about.fixture, about.device, about.driver)),
        ("tolerance", about.tolerance.clone()),
        ("run", "amber -d -v 1.2 -t spv1.5 case.amber".into()),
    ] {
        // A comment ends with its line.
        let _ = writeln!(text, "# {key}: {}", value.replace(['\n', '\r'], " "));
    }
    text += "# The modules have scalar block layout, which Amber can't ask for: drivers take it, the validation layer (-d) does not.\n\n";
    if let Some(seconds) = about.seconds {
        let _ = writeln!(text, "# The device did not end this: a run may take half of what two of them may.");
        let _ = writeln!(text, "SET ENGINE_DATA fence_timeout_ms {}\n", (500.0 * seconds).ceil());
    }
    text
}

/// Declares the pipeline of each dispatch.
fn pipelines(text: &mut String, case: &Case, kind: Type, names: &[String]) {
    for (k, (dispatch, module)) in case.dispatches.iter().zip(names).enumerate() {
        let _ = write!(text, "\nPIPELINE compute run{k}{}\n  ATTACH {module}", kind.ending());
        let by_device = set_by_device(&dispatch.kernel, &dispatch.spirv, dispatch.lanes);
        for (id, value) in (0..).zip(dispatch.constants.iter().copied()).chain(by_device) {
            let _ = write!(text, " SPECIALIZE {id} AS uint32 {value}");
        }
        text.push('\n');
        for b in &dispatch.bindings {
            let part = &case.buffers[b.buffer];
            let ending = if case.writes(b.buffer) { kind.ending() } else { "" };
            let _ =
                write!(text, "  BIND BUFFER {}{ending} AS storage DESCRIPTOR_SET 0 BINDING {}", part.name, b.number);
            if b.bytes < 4 * part.before.len() as u64 {
                let _ = write!(text, " DESCRIPTOR_RANGE {}", b.bytes);
            }
            text.push('\n');
        }
        if !dispatch.push.is_empty() {
            let _ = writeln!(text, "  BIND BUFFER push{k} AS push_constant");
        }
        *text += "END\n";
    }
}

/// Declares the buffers that dispatches bind, and those that they are compared with.
fn buffers(text: &mut String, case: &Case, kind: Type) {
    for (b, part) in case.buffers.iter().enumerate() {
        let (name, writes) = (&part.name, case.writes(b));
        if kind == Type::Floats && !writes {
            continue;
        }
        let mut declare = |name: &str, file: &str| {
            let (data_type, count) = (kind.name(), part.before.len());
            let _ = writeln!(text, "BUFFER {name} DATA_TYPE {data_type} SIZE {count} FILE BINARY {file}");
        };
        declare(&format!("{name}{}", kind.ending()), &format!("{name}.before"));
        if kind == Type::Bits && writes && part.allowed.iter().all(|allowed| *allowed == BITS) {
            declare(&format!("{name}_expected"), &format!("{name}.expected"));
        }
    }
}

/// Writes what a written buffer must hold.
fn expectations(text: &mut String, part: &Part) {
    let name = &part.name;
    if part.allowed.iter().all(|allowed| *allowed == BITS) {
        let _ = writeln!(text, "EXPECT {name} EQ_BUFFER {name}_expected");
        return;
    }
    let mut word = 0;
    while word < part.allowed.len() {
        let allowed = part.allowed[word];
        let value = f32::from_bits(part.expected[word]);
        if allowed == ANY {
            word += 1;
        } else if allowed >= 0.0 && value.is_finite() {
            let _ =
                writeln!(text, "EXPECT {name}_f IDX {} TOLERANCE {} EQ {}", 4 * word, decimal(allowed), decimal(value));
            word += 1;
        } else {
            let bits = |k: &usize| part.allowed[*k] == BITS || !f32::from_bits(part.expected[*k]).is_finite();
            let own = |k: &usize| part.allowed[*k] != ANY && bits(k);
            let end = (word..part.allowed.len().min(word + VALUES)).take_while(own).last().unwrap_or(word) + 1;
            let _ = writeln!(text, "EXPECT {name} IDX {} EQ {}", 4 * word, listed(&part.expected[word..end]));
            word = end;
        }
    }
}

/// Integers, separated by spaces.
fn listed(words: &[u32]) -> String {
    words.iter().map(u32::to_string).collect::<Vec<_>>().join(" ")
}

/// A float that reads back as the same single; Amber takes a number for a float by its point.
fn decimal(value: f32) -> String {
    format!("{value:.9e}")
}
