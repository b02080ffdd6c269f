//! How long a frame would take on another device: counted work and chains, by a few fixed figures of that device.
//!
//! Dispatches between which there is no barrier run side by side. They take about as long as the largest of three
//! things: issuing all their instructions at the device's rate; the waits of all invocations, shared out over as many
//! as the device holds at a time; and the longest chain: the most steps, loads and waits of any invocation, added.
//! Launches and barriers come on top. Left out are divergent branches, loads of scattered words, which take turns, and
//! memory beyond the cache: neither how long it takes nor how much it moves.

use std::io::Read as _;
use std::path::Path;

use serde::Deserialize;

use super::work::{After, Counted, Interpreted, counted, planned, row_of, timed};
use super::{Settings, variant};
use crate::error::{Error, Input, Result};
use crate::gpu::count::{Chain, Tally};
use crate::gpu::{Device, Timed};
use crate::measure::interpret::stage::{Interpreter, Settings as Widths};
use crate::pipeline::plan::ShadingMethod;
use crate::scene::{Scene, from_toml};
use crate::state::Width;

/// Most bytes of a device's file.
const MOST: u64 = 1 << 16;
/// The devices that are known by name.
const KNOWN: &[(&str, &str)] =
    &[("h100", include_str!("models/h100.toml")), ("navi21", include_str!("models/navi21.toml"))];

/// A device, as far as predictions know it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Its name.
    pub name: String,
    /// Its multiprocessors.
    pub multiprocessors: f64,
    /// Instructions, counted once an invocation, that a multiprocessor issues a cycle.
    pub issued_a_cycle: f64,
    /// Cycles of a nanosecond.
    pub clock_ghz: f64,
    /// Invocations that a multiprocessor holds at a time.
    pub threads: f64,
    /// Cycles from an instruction to one that needs its result.
    pub instruction_cycles: f64,
    /// Cycles of a load that is served by the cache of all multiprocessors.
    pub load_cycles: f64,
    /// Cycles of a load of shared memory, of a barrier in a group that nobody is late for, and of an exchange.
    pub shared_cycles: f64,
    /// Microseconds of a dispatch that does nothing.
    pub dispatch_us: f64,
    /// Microseconds of a barrier.
    pub barrier_us: f64,
    /// Microseconds of a submission and the wait for it.
    pub submission_us: f64,
}

/// What a stage or a kernel would take, microseconds a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predicted {
    /// Its name.
    pub stage: String,
    /// Its dispatches.
    pub dispatches: usize,
    /// Its barriers.
    pub barriers: usize,
    /// Invocations, whole groups.
    pub invocations: u64,
    /// Instructions of all invocations.
    pub instructions: u64,
    /// Instructions that wait for one another, of the longest invocation, summed over the dispatches.
    pub longest_steps: u64,
    /// Likewise loads of buffers.
    pub longest_loads: u64,
    /// Likewise loads of shared memory, barriers and exchanges.
    pub longest_shared: u64,
    /// Launches and barriers.
    pub launches_us: f64,
    /// Issuing instructions, where that bounds what runs at a time.
    pub issue_us: f64,
    /// Holding invocations, one after the other, where that bounds it.
    pub residence_us: f64,
    /// All of a dispatch's time, where its longest invocation outlasts what runs beside it.
    pub chain_us: f64,
}

/// A frame as another device would take it.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The device.
    pub model: Model,
    /// The device that counted.
    pub counted_on: String,
    /// The scene.
    pub scene: String,
    /// Stages or kernels, in the order of the frame.
    pub rows: Vec<Predicted>,
    /// Submissions of a frame.
    pub submissions: u64,
}

impl Model {
    /// The names of the devices that are known.
    pub fn names() -> impl Iterator<Item = &'static str> {
        KNOWN.iter().map(|(name, _)| *name)
    }

    /// The device of this name, or that a file describes.
    pub fn read(name: &str) -> Result<Self> {
        let path = Path::new(name);
        let text = match KNOWN.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => (*text).to_string(),
            None => read_file(path)?,
        };
        let model: Self = toml::from_str(&text).map_err(|error| from_toml(&error, &text, path))?;
        let wrong = model.figures().into_iter().find(|(_, figure)| !(figure.is_finite() && *figure > 0.0));
        wrong.map_or(Ok(model.clone()), |(key, figure)| {
            let line = crate::scene::line_of(&text, key);
            let fault = Input { line, ..Input::new("not a figure of a device").file(path).key(key) };
            Err(fault.found(figure).expected("a number above 0").into())
        })
    }

    /// The figures with their keys.
    fn figures(&self) -> [(&'static str, f64); 10] {
        [
            ("multiprocessors", self.multiprocessors),
            ("issued_a_cycle", self.issued_a_cycle),
            ("clock_ghz", self.clock_ghz),
            ("threads", self.threads),
            ("instruction_cycles", self.instruction_cycles),
            ("load_cycles", self.load_cycles),
            ("shared_cycles", self.shared_cycles),
            ("dispatch_us", self.dispatch_us),
            ("barrier_us", self.barrier_us),
            ("submission_us", self.submission_us),
        ]
    }

    /// Microseconds of one dispatch: to issue its instructions, to hold its invocations, and of its chain.
    fn bounds(&self, tally: &Tally) -> [f64; 3] {
        let wait = |chain: Chain| {
            let (loads, shared) = (chain.loads as f64 * self.load_cycles, chain.shared as f64 * self.shared_cycles);
            chain.steps as f64 * self.instruction_cycles + loads + shared
        };
        let cycles = [
            tally.instructions as f64 / (self.multiprocessors * self.issued_a_cycle),
            wait(tally.chains) / (self.multiprocessors * self.threads),
            wait(tally.longest),
        ];
        cycles.map(|cycles| 1e-3 * cycles / self.clock_ghz)
    }
}

/// The text of a file.
fn read_file(path: &Path) -> Result<String> {
    let fault = |error: std::io::Error| {
        if error.kind() != std::io::ErrorKind::NotFound {
            return Input::new(format!("the device's figures could not be read: {error}")).file(path);
        }
        let names: Vec<&str> = Model::names().collect();
        let fault = Input::new("no such device and no such file").key("--as").found(path.display());
        fault.expected(format!("{}, or a TOML file that describes one", names.join(", ")))
    };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(fault)?;
    file.take(MOST + 1).read_to_string(&mut text).map_err(fault)?;
    if text.len() as u64 > MOST {
        return Err(Input::new("too long").file(path).expected(format!("at most {MOST} bytes")).into());
    }
    Ok(text)
}

impl Predicted {
    /// Adds a dispatch, and what it takes of the time of those that run beside it.
    fn add(&mut self, tally: &Tally, (bound, us): (Bound, f64)) {
        self.dispatches += usize::try_from(tally.dispatches).unwrap_or(usize::MAX);
        self.invocations += tally.invocations;
        self.instructions += tally.instructions;
        self.longest_steps += tally.longest.steps;
        self.longest_loads += tally.longest.loads;
        self.longest_shared += tally.longest.shared;
        match bound {
            Bound::Issue => self.issue_us += us,
            Bound::Residence => self.residence_us += us,
            Bound::Chain => self.chain_us += us,
        }
    }

    /// Microseconds of all.
    #[must_use]
    pub fn us(&self) -> f64 {
        self.launches_us + self.issue_us + self.residence_us + self.chain_us
    }

    /// What most of the time is.
    #[must_use]
    pub fn bound(&self) -> &'static str {
        let parts = [
            ("launches", self.launches_us),
            ("issue", self.issue_us),
            ("residence", self.residence_us),
            ("chain", self.chain_us),
        ];
        parts.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("-", |(name, _)| name)
    }
}

impl Prediction {
    /// Microseconds of a frame on the device.
    #[must_use]
    pub fn us(&self) -> f64 {
        self.rows.iter().map(Predicted::us).sum()
    }
}

/// What bounds a dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bound {
    Issue,
    Residence,
    Chain,
}

/// What each of these dispatches, between which there is no barrier, takes of the time of all: that of issuing its
/// instructions, or of holding its invocations where this bounds them; and what the longest chain takes beyond that is
/// the time of the dispatch that has it.
fn shared(model: &Model, tallies: &[([String; 2], Tally)]) -> Vec<(Bound, f64)> {
    let bounds: Vec<[f64; 3]> = tallies.iter().map(|(_, tally)| model.bounds(tally)).collect();
    let [issue, residence] = [0, 1].map(|kind| bounds.iter().map(|bound| bound[kind]).sum::<f64>());
    let (bound, kind) = if residence > issue { (Bound::Residence, 1) } else { (Bound::Issue, 0) };
    let mut shares: Vec<(Bound, f64)> = bounds.iter().map(|of| (bound, of[kind])).collect();
    let longest = (0..bounds.len()).max_by(|a, b| bounds[*a][2].total_cmp(&bounds[*b][2]));
    if let Some(longest) = longest {
        let beyond = bounds[longest][2] - issue.max(residence);
        if beyond > 0.0 {
            shares[longest] = (Bound::Chain, shares[longest].1 + beyond);
        }
    }
    shares
}

/// The rows of a frame, stages, kernels or dispatches, from what each dispatch has done and what it begins after.
fn rows(model: &Model, timed: Timed, tallies: &[([String; 2], Tally)], after: &[After]) -> Vec<Predicted> {
    let mut rows: Vec<Predicted> = Vec::new();
    let (mut shares, mut begin) = (Vec::new(), 0);
    for end in 1..=tallies.len() {
        if after.get(end) != Some(&After::Nothing) {
            shares.extend(shared(model, &tallies[begin..end]));
            begin = end;
        }
    }
    for (((names, tally), share), after) in tallies.iter().zip(shares).zip(after) {
        let Some(name) = row_of(timed, names, tally) else { continue };
        let place = rows.iter().position(|row| row.stage == name).unwrap_or(rows.len());
        if place == rows.len() {
            rows.push(Predicted { stage: name, ..Predicted::default() });
        }
        rows[place].add(tally, share);
        // Dispatches that count together have a barrier each, but for the first.
        let together = usize::try_from(tally.dispatches).unwrap_or(usize::MAX).saturating_sub(1);
        rows[place].barriers += usize::from(*after == After::Barrier) + together;
    }
    for row in &mut rows {
        row.launches_us = row.dispatches as f64 * model.dispatch_us + row.barriers as f64 * model.barrier_us;
    }
    rows
}

/// A frame of this scene as a device of this model would take it, counted on another one. Kernels share their work as
/// they do on the device that counts: [`Choices::lanes`](crate::gpu::Choices) says how wide.
pub fn predict(scene: &Scene, device: &Device, settings: &Settings, model: &Model) -> Result<Prediction> {
    if settings.options.transport == ShadingMethod::Octree {
        return Err(foreign("predicts what a device runs, not the host", "octree"));
    }
    let mut plain = variant(scene, Some(device), settings)?.session;
    // A frame as others are, after those that fill buffers.
    let before = device.submissions();
    plain.frame(settings.change)?;
    let submissions = device.submissions() - before;
    let Counted { session, tallies } = counted(scene, &device.counting(), settings, &mut plain)?;
    let planned = planned(&session, settings.change, Width::of(device))?;
    let after = after(planned, tallies.iter().map(|([kernel, _], _)| kernel));
    let rows = rows(model, timed(&session), &tallies, &after);
    let (counted_on, scene) = (device.name().to_string(), scene.name.clone());
    Ok(Prediction { model: model.clone(), counted_on, scene, rows, submissions })
}

/// What each of these kernels' dispatches begins after, by the plan of their frame. A kernel that the plan dispatches
/// once may have gone level by level. All have a barrier where the frame was another: made anew, or too long to count.
fn after<'a>(planned: Vec<(String, After)>, kernels: impl ExactSizeIterator<Item = &'a String>) -> Vec<After> {
    let (count, mut left, mut last) = (kernels.len(), planned.into_iter().peekable(), None);
    let of = |kernel: &'a String| match left.next_if(|(next, _)| next == kernel) {
        Some((_, after)) => {
            last = Some(kernel);
            Some(after)
        }
        None => (last == Some(kernel)).then_some(After::Barrier),
    };
    let found: Option<Vec<After>> = kernels.map(of).collect();
    found.filter(|_| left.next().is_none()).unwrap_or_else(|| vec![After::Barrier; count])
}

/// The same, counted by the interpreter, which shares work as its settings say.
pub fn predict_interpreted(
    scene: &Scene,
    interpreter: &Interpreter,
    (settings, timed): (&Settings, Timed),
    model: &Model,
) -> Result<Prediction> {
    let fault = |what: &str| Err(foreign("predicts on the interpreter what a frame has in it from the start", what));
    match settings.options.transport {
        ShadingMethod::Octree => return fault("octree"),
        ShadingMethod::Walk => return fault("walk"),
        _ => {}
    }
    let Interpreted { tallies, after, submissions, .. } = Interpreted::of(scene, interpreter, settings)?;
    let rows = rows(model, timed, &tallies, &after);
    let Widths { lanes, subgroup, .. } = interpreter.settings();
    let counted_on = format!("the interpreter, {lanes} invocations an item, subgroups of {subgroup}");
    Ok(Prediction { model: model.clone(), counted_on, scene: scene.name.clone(), rows, submissions })
}

/// The error that what was asked for cannot be predicted.
fn foreign(what: &str, found: &str) -> Error {
    Input::new(what).key("--as").found(found).expected("another --transport").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 multiprocessors that issue 8 instructions and hold 100 invocations, at 1 cycle a nanosecond.
    const SMALL: &str = "name = 'small'\nmultiprocessors = 2\nissued_a_cycle = 8\nclock_ghz = 1\nthreads = 100\n\
                         instruction_cycles = 4\nload_cycles = 250\nshared_cycles = 30\ndispatch_us = 2\nbarrier_us = 1\n\
                         submission_us = 20\n";

    #[test]
    fn the_largest_bound_counts_of_what_runs_side_by_side() {
        let model: Model = toml::from_str(SMALL).unwrap();
        let chain = |steps: u64| Chain { steps, loads: 0, shared: 0 };
        let tally = |instructions: u64, chains: Chain, longest: Chain| Tally {
            instructions,
            chains,
            longest,
            dispatches: 1,
            ..Tally::default()
        };
        // One invocation of 1,000 steps, 10 loads and 5 barriers: 4,000 + 2,500 + 150 cycles.
        let long = Chain { steps: 1000, loads: 10, shared: 5 };
        // 160,000 instructions at 16 a cycle; 100,000 steps of 4 cycles, 200 invocations at a time.
        let (many, full) = (tally(160_000, chain(1000), chain(10)), tally(100, chain(1_000_000), chain(10)));
        let all =
            [tally(1000, long, long), many, full].map(|tally| (["transport/blocks/push", ""].map(String::from), tally));
        let of = |after: After| {
            let after = [After::Submission, after, after];
            rows(&model, Timed::Kernels, &all, &after).pop().unwrap()
        };
        let row = of(After::Barrier);
        assert_eq!([row.chain_us, row.issue_us, row.residence_us, row.launches_us], [6.65, 10.0, 20.0, 8.0]);
        assert_eq!((row.us(), row.bound()), (44.65, "residence"));
        assert_eq!((row.longest_steps, row.longest_loads, row.longest_shared), (1020, 10, 5));
        // Side by side, 0.033 + 0.02 + 20 us of residence bound all three.
        let beside = of(After::Nothing);
        assert_eq!((beside.launches_us, beside.bound()), (6.0, "residence"));
        assert!((beside.us() - 26.05325).abs() < 1e-9, "{beside:?}");
        // A chain goes on after the others have been issued: 0.5 us of its 6.65.
        let few = [all[0].clone(), (all[1].0.clone(), tally(8_000, chain(10), chain(10)))];
        let [first, second] = shared(&model, &few)[..] else { panic!("two dispatches") };
        assert!((first.1 - 6.15).abs() < 1e-9 && first.0 == Bound::Chain, "{first:?}");
        assert_eq!(second, (Bound::Issue, 0.5));
    }

    #[test]
    fn dispatches_begin_as_planned() {
        use After::{Barrier, Nothing, Submission};
        let planned = [("a", Submission), ("climb", Barrier), ("b", Nothing), ("b", Barrier)];
        let planned = || planned.map(|(kernel, after)| (kernel.to_string(), after)).to_vec();
        let of = |kernels: &[&str]| after(planned(), kernels.iter().map(|k| k.to_string()).collect::<Vec<_>>().iter());
        assert_eq!(of(&["a", "climb", "climb", "b", "b"]), [Submission, Barrier, Barrier, Nothing, Barrier]);
        assert_eq!(of(&["a", "b"]), [Barrier; 2]);
        assert_eq!(of(&["a", "climb"]), [Barrier; 2]);
    }

    #[test]
    fn the_built_in_models_and_files_are_read() {
        for name in Model::names() {
            assert!(Model::read(name).unwrap().clock_ghz > 1.0, "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Model::read(path.to_str().unwrap()).map_err(|error| error.to_string())
        };
        assert_eq!(read(SMALL).unwrap().threads, 100.0);
        for (text, words) in [
            (SMALL.replace("threads = 100", "threads = 0"), ["own.toml:5: threads", "found 0", "above 0"]),
            (SMALL.replace("clock_ghz = 1", "clock_ghz = 'fast'"), ["own.toml:4", "clock_ghz", "fast"]),
            (SMALL.replace("name = 'small'", "nam = 'small'"), ["own.toml:1", "unknown key", "nam"]),
        ] {
            let told = read(&text).unwrap_err();
            assert!(words.iter().all(|word| told.contains(word)), "{told}");
        }
        let told = Model::read("h200x").unwrap_err().to_string();
        assert!(["--as", "h200x", "h100, navi21"].iter().all(|word| told.contains(word)), "{told}");
    }
}
