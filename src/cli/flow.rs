//! The flow of data through a frame as a drawing: stages from top to bottom in the order of the frame, with the loops
//! that they run in, and beside them a line for each buffer from its first use to its last.

use std::fmt::Write;
use std::path::Path;

use milkglass::error::Result;
use milkglass::internals::layout::{BUFFER_IDS, BufferId};
use milkglass::internals::pipeline::frame::{FRAME, Part};
use milkglass::internals::state::{Granularity, Host, Role, Stage};
use milkglass::internals::view::atomic_file::write_atomically;

/// Height of a row and width of a lane of buffers, pixels.
const ROW: usize = 16;
const LANE: usize = 20;
/// Where the names of stages and the lanes begin, from the left.
const NAMES: usize = 110;
const LANES: usize = 290;
/// Rows above the first one, which say what the marks mean.
const HEAD: usize = 3;
/// Letters of a buffer's name that take the height of a row: names are written along the lines, downwards.
const LETTERS: usize = 3;

/// What a step of the frame does with a buffer.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    Read,
    Write,
    Update,
}

/// A row of the drawing.
struct Row {
    /// The name of the stage, or the title of a section.
    name: &'static str,
    /// What the stage does; empty for a title.
    about: &'static str,
    /// What the stage does with buffers.
    uses: Vec<(BufferId, Use)>,
    /// Whether the frame runs it.
    runs: bool,
}

/// A loop of stages: its name, and its first and last row.
type Loop = (&'static str, usize, usize);

/// A line of a buffer: its lane and its rows.
struct Line {
    buffer: BufferId,
    lane: usize,
    first: usize,
    last: usize,
}

impl Line {
    /// The row in which the line and the name along it end.
    fn end(&self) -> usize {
        self.last.max(self.first + self.buffer.spec().name.len() / LETTERS)
    }
}

/// What a stage does with buffers.
fn uses(stage: &Stage) -> Result<Vec<(BufferId, Use)>> {
    let reads = stage.reads()?.into_iter().map(|buffer| (buffer, Use::Read));
    let kind = |role: Role| if role == Role::Update { Use::Update } else { Use::Write };
    Ok(reads.chain(stage.writes.iter().map(|&(buffer, role, _)| (buffer, kind(role)))).collect())
}

/// The rows of the frame, and its loops.
fn rows(runs: &dyn Fn(&str) -> bool) -> Result<(Vec<Row>, Vec<Loop>)> {
    let (mut rows, mut loops) = (Vec::new(), Vec::new());
    for section in FRAME {
        rows.push(Row { name: section.title, about: "", uses: Vec::new(), runs: true });
        for part in section.parts {
            let first = rows.len();
            match part {
                Part::Loop(granularity, stages) => {
                    for stage in *stages {
                        let Stage { name, about, .. } = stage;
                        rows.push(Row { name, about, uses: uses(stage)?, runs: runs(name) });
                    }
                    loops.extend(each(*granularity).map(|name| (name, first, rows.len() - 1)));
                }
                Part::Host(Host { name, about, reads, writes, .. }) => {
                    let uses = vec![(*reads, Use::Read), (*writes, Use::Write)];
                    rows.push(Row { name, about, uses, runs: runs(name) });
                    loops.push(("on the host", first, first));
                }
            }
        }
    }
    Ok((rows, loops))
}

/// The name of a loop; `None` where stages run once.
fn each(granularity: Granularity) -> Option<&'static str> {
    Some(match granularity {
        Granularity::Scene => return None,
        Granularity::Object => "each object",
        Granularity::Chunk => "each chunk",
        Granularity::Group => "each group",
        Granularity::Batch => "each batch",
        Granularity::Iteration => "each iteration",
    })
}

/// The lines of all buffers that the frame uses, in as few lanes as hold them and their names.
fn lines(rows: &[Row]) -> Vec<Line> {
    let mut lines: Vec<Line> = BUFFER_IDS
        .iter()
        .filter_map(|&buffer| {
            let uses = |row: &Row| row.uses.iter().any(|(used, _)| *used == buffer);
            let first = rows.iter().position(uses)?;
            let last = rows.iter().rposition(uses)?;
            Some(Line { buffer, lane: 0, first, last })
        })
        .collect();
    lines.sort_by_key(|line| (line.first, line.last));
    // The first free row of each lane.
    let mut free: Vec<usize> = Vec::new();
    for line in &mut lines {
        line.lane = free.iter().position(|row| *row <= line.first).unwrap_or(free.len());
        if line.lane == free.len() {
            free.push(0);
        }
        free[line.lane] = 2 + line.end();
    }
    lines
}

/// The colour of what the frame leaves out.
const LEFT_OUT: &str = "#b0b0b0";

/// The vertical middle of a row, pixels.
fn middle(row: usize) -> usize {
    (HEAD + row) * ROW + ROW / 2
}

/// A drawing in the making: SVG, an element a line.
struct Drawing(String);

impl Drawing {
    /// Adds an element.
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        let _ = self.0.write_fmt(text);
        self.0.push('\n');
    }

    /// Writes the name of a stage; a browser shows what it does to a pointer above it.
    fn stage(&mut self, row: usize, Row { name, about, uses, runs }: &Row) {
        let y = middle(row) + 4;
        let color = if *runs { "black" } else { LEFT_OUT };
        let list = |wanted: &[Use]| {
            let names = uses.iter().filter(|(_, kind)| wanted.contains(kind)).map(|(buffer, _)| buffer.spec().name);
            names.collect::<Vec<_>>().join(", ")
        };
        let (reads, writes) = (list(&[Use::Read, Use::Update]), list(&[Use::Write, Use::Update]));
        self.put(format_args!(
            "<text x=\"{NAMES}\" y=\"{y}\" fill=\"{color}\">{name}<title>{about}\nreads {reads}\nwrites {writes}\
             </title></text>"
        ));
    }

    /// Draws a bracket around the rows of a loop.
    fn bracket(&mut self, (name, first, last): Loop) {
        let (top, bottom, y) = (middle(first) - 6, middle(last) + 6, middle(first) + 4);
        self.put(format_args!("<text x=\"10\" y=\"{y}\" fill=\"#666\" font-size=\"10\">{name}</text>"));
        self.put(format_args!("<path d=\"M{0} {top}h-5V{bottom}h5\" fill=\"none\" stroke=\"#666\"/>", NAMES - 6));
    }

    /// Draws the line of a buffer, its name along it, and a mark for each use.
    fn line(&mut self, rows: &[Row], Line { buffer, lane, first, last }: &Line) {
        let x = LANES + lane * LANE;
        let used = |row: &&Row| row.uses.iter().any(|(known, _)| known == buffer);
        let writes = |row: &Row| row.uses.iter().any(|(known, kind)| known == buffer && *kind != Use::Read);
        let color = match () {
            () if !rows.iter().filter(used).any(|row| row.runs) => LEFT_OUT,
            () if !rows.iter().any(writes) => "#1f5fa8",
            () => "black",
        };
        let (top, bottom, name) = (middle(*first), middle(*last), buffer.spec().name);
        self.put(format_args!("<path d=\"M{x} {top}V{bottom}\" stroke=\"{color}\"/>"));
        self.put(format_args!(
            "<text transform=\"translate({} {}) rotate(90)\" fill=\"{color}\" font-size=\"9\">{name}</text>",
            x + 4,
            top + 6
        ));
        for (k, row) in rows.iter().enumerate() {
            for (_, kind) in row.uses.iter().filter(|(known, _)| known == buffer) {
                self.mark([x, middle(k)], *kind, if row.runs { color } else { LEFT_OUT });
            }
        }
    }

    /// Marks a use of a buffer.
    fn mark(&mut self, [x, y]: [usize; 2], kind: Use, color: &str) {
        let (fill, ring) = match kind {
            Use::Read => ("white", 3),
            Use::Write | Use::Update => (color, 3),
        };
        self.put(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{ring}\" fill=\"{fill}\" stroke=\"{color}\"/>"));
        if kind == Use::Update {
            self.put(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"1.5\" fill=\"white\"/>"));
        }
    }

    /// Writes the title of a section over the lines, with a white rim.
    fn title(&mut self, row: usize, name: &str) {
        let y = middle(row) + 4;
        self.put(format_args!(
            "<text x=\"10\" y=\"{y}\" font-weight=\"bold\" stroke=\"white\" stroke-width=\"4\" \
             paint-order=\"stroke\">{name}</text>"
        ));
    }
}

/// Draws the frame; stages that do not run are grey, and so are buffers that only they use.
fn drawing(runs: &dyn Fn(&str) -> bool) -> Result<String> {
    let (rows, loops) = rows(runs)?;
    let lines = lines(&rows);
    let lanes = lines.iter().map(|line| line.lane + 1).max().unwrap_or(0);
    let end = lines.iter().map(|line| line.end() + 2).max().unwrap_or(0).max(rows.len());
    let (width, height) = (LANES + (lanes + 1) * LANE, (HEAD + end) * ROW);
    let mut drawing = Drawing(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"10\" y=\"20\">Time runs downwards. A line is a buffer: filled where a stage writes it, open where \
         one reads it, both where it does both.</text>\n\
         <text x=\"10\" y=\"36\"><tspan fill=\"#1f5fa8\">Blue</tspan>: written by the host only. \
         <tspan fill=\"{LEFT_OUT}\">Grey</tspan>: left out.</text>\n"
    ));
    let (titles, stages): (Vec<_>, Vec<_>) = rows.iter().enumerate().partition(|(_, row)| row.about.is_empty());
    stages.into_iter().for_each(|(k, row)| drawing.stage(k, row));
    loops.into_iter().for_each(|bounds| drawing.bracket(bounds));
    lines.iter().for_each(|line| drawing.line(&rows, line));
    titles.into_iter().for_each(|(k, row)| drawing.title(k, row.name));
    Ok(drawing.0 + "</svg>\n")
}

/// Writes the drawing to a file.
pub(super) fn write(path: &Path, runs: &dyn Fn(&str) -> bool) -> Result<()> {
    let svg = drawing(runs)?;
    write_atomically(path, |beside| std::fs::write(beside, svg).map_err(|error| error.to_string()))
}
