//! What of Vulkan and SPIR-V fixtures execute on a device: instructions by counting how often each block of each kernel
//! runs, capabilities by kernels that begin, limits by the largest values in use; and what nothing here touches.

use std::collections::{BTreeMap, BTreeSet};

use super::fixtures::Fixture;
use super::table::{Column, Table};
use crate::error::Result;
use crate::gpu::Device;
use crate::gpu::count::Code;
use crate::layout::BUFFER_IDS;
use crate::state::{DeviceState, Width, dispatches};

/// Where something is used.
#[derive(Clone, Debug, Default)]
struct Use {
    /// The fixtures that execute it.
    fixtures: BTreeSet<String>,
    /// The kernels that have it, whether it runs or not.
    kernels: BTreeSet<String>,
}

/// The largest value of something that a device limits.
#[derive(Clone, Debug)]
struct Reached {
    value: u64,
    most: u64,
    fixture: String,
}

/// What was executed on a device.
pub struct Coverage {
    /// The device, with kernels that count.
    device: Device,
    codes: BTreeMap<Code, Use>,
    limits: BTreeMap<&'static str, Reached>,
}

impl Coverage {
    /// Nothing yet.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        Self { device: device.counting(), codes: BTreeMap::new(), limits: BTreeMap::new() }
    }

    /// Runs the steps of a fixture as one frame, with kernels that count.
    pub fn add(&mut self, fixture: &Fixture) -> Result<()> {
        let mut copy = DeviceState::new(&self.device, false)?;
        copy.upload(&fixture.state, BUFFER_IDS)?;
        copy.run(&fixture.state, &fixture.steps)?;
        for ([kernel, _], tally) in copy.kernels().tallies()? {
            for code in tally.listed {
                let own = self.codes.entry(code.clone()).or_default();
                own.kernels.insert(kernel.clone());
                if tally.executed.contains(&code) {
                    own.fixtures.insert(fixture.name.clone());
                }
            }
        }
        let limits = *self.device.limits();
        for dispatch in dispatches(&fixture.state, &fixture.steps, Width::of(&self.device))? {
            let kernel = copy.kernels().get(&dispatch.kernel, &dispatch.constants)?;
            let groups = dispatch.invocations.map_or([0; 3], |count| kernel.grid(count as u64));
            let bound = dispatch.bound(&fixture.state)?;
            let largest = bound.iter().map(|bound| bound.range[1] - bound.range[0]).max().unwrap_or_default();
            for (name, value, most) in [
                ("bytes of a binding", largest, limits.binding_bytes),
                ("bytes of push constants", kernel.push_bytes.into(), limits.push_bytes.into()),
                ("groups of a direct dispatch, first dimension", groups[0].into(), limits.groups[0].into()),
                ("groups of a direct dispatch, second dimension", groups[1].into(), limits.groups[1].into()),
                ("invocations of a group", kernel.group.into(), limits.group_invocations.into()),
                ("storage buffers of a kernel", kernel.accesses.len() as u64, limits.storage_buffers.into()),
            ] {
                let first = Reached { value: 0, most, fixture: String::new() };
                let known = self.limits.entry(name).or_insert(first);
                if value > known.value {
                    *known = Reached { value, most, fixture: fixture.name.clone() };
                }
            }
        }
        Ok(())
    }

    /// The kind, name and state of everything, how many kernels have it, and the fixtures that execute it; also of
    /// what no kernel has that ran.
    fn rows(&self) -> Vec<[String; 5]> {
        let mut rows: Vec<[String; 5]> = Vec::new();
        for (code, own) in &self.codes {
            let fixtures: Vec<&str> = own.fixtures.iter().map(String::as_str).collect();
            let how = if fixtures.is_empty() { "not reached" } else { "executed" };
            let kernels = own.kernels.len().to_string();
            rows.push([code.kind().into(), code.name(), how.into(), kernels, fixtures.join("; ")]);
        }
        let absent = Code::of_compute().filter(|code| !self.codes.contains_key(code));
        rows.extend(
            absent.map(|code| {
                [code.kind().into(), code.name(), "in no kernel that ran".into(), "0".into(), String::new()]
            }),
        );
        for (name, Reached { value, most, fixture }) in &self.limits {
            rows.push(["limit".into(), (*name).into(), format!("{value} of {most}"), String::new(), fixture.clone()]);
        }
        for (kind, [used, others]) in [("extension", self.device.extensions()), ("feature", self.device.features())] {
            let row = |name: String, how: &str| [kind.into(), name, how.into(), String::new(), String::new()];
            rows.extend(used.into_iter().map(|name| row(name, "in use")));
            rows.extend(others.into_iter().map(|name| row(name, "offered, not in use")));
        }
        rows
    }

    /// A line for each kind and state, with all names.
    #[must_use]
    pub fn text(&self) -> String {
        let rows = self.rows();
        let mut groups: Vec<([&str; 2], Vec<String>)> = Vec::new();
        for row in &rows {
            let limit = row[0] == "limit";
            let key = [row[0].as_str(), if limit { "largest" } else { row[2].as_str() }];
            let name = if limit { format!("{} {}", row[1], row[2]) } else { row[1].clone() };
            match groups.iter_mut().find(|(known, _)| *known == key) {
                Some((_, names)) => names.push(name),
                None => groups.push((key, vec![name])),
            }
        }
        // Most extensions are of graphics.
        let line = |([kind, state], names): &([&str; 2], Vec<String>)| match names.len() {
            count if *kind == "extension" && count > 20 => format!("{kind}, {state}: {count}\n"),
            count => format!("{kind}, {state}: {count}: {}\n", names.join(", ")),
        };
        let lines: String = groups.iter().map(line).collect();
        format!("\ncoverage of {}, by blocks that ran\n{lines}", self.device.name())
    }
}

/// A row for everything, of each device.
#[must_use]
pub fn table(all: &[Coverage]) -> Table {
    let own = |coverage: &Coverage| {
        let device = coverage.device.name().to_string();
        coverage.rows().into_iter().map(move |row| (device.clone(), row))
    };
    let rows: Vec<(String, [String; 5])> = all.iter().flat_map(own).collect();
    let columns: [Column<'_, (String, [String; 5])>; 6] = [
        ("device", "", &|(device, _)| device.clone()),
        ("kind", "", &|(_, row)| row[0].clone()),
        ("name", "", &|(_, row)| row[1].clone()),
        ("state", "", &|(_, row)| row[2].clone()),
        ("kernels", "", &|(_, row)| row[3].clone()),
        ("fixtures", "", &|(_, row)| row[4].clone()),
    ];
    Table::of(&rows, &columns)
}
