//! The functions of a module as blocks. What a function calls is decoded in place of the call. A conditional branch
//! that a constant decides is none, as compilers have it.

use std::collections::{HashMap, HashSet};

use spirq::spirv::Op;

use super::builder::{Builder, Value, part_of};
use super::code::{Act, Block, Decoded, Edge, End};
use super::memory::is_undefined;

/// Where an edge leads that leaves the function, until the block after the call is there.
const BACK: usize = usize::MAX;
/// Most calls within each other; SPIR-V has no recursion.
const MOST_CALLS: usize = 64;
/// Most arguments of a call, as SPIR-V has it.
const MOST_ARGUMENTS: usize = 255;
/// Most blocks of a kernel.
const MOST_BLOCKS: usize = 1 << 17;
/// The numbers of a phi, and the id of its value by the label of the block before.
struct Phi {
    registers: Vec<u32>,
    from: HashMap<u32, u32>,
}

/// A function as it is being decoded. Until it ends, edges of its blocks lead to labels.
#[derive(Default)]
struct Frame {
    /// The first block of each label.
    first: HashMap<u32, usize>,
    /// Its blocks that end by a branch, the label that each belongs to, and those where its ways meet.
    ends: Vec<(usize, u32, Vec<u32>)>,
    /// Those of each label.
    phis: HashMap<u32, Vec<Phi>>,
    label: u32,
    /// Whether a label has begun a block that has not ended.
    open: bool,
    /// What the last instruction says of where ways meet: labels.
    merges: Vec<u32>,
    /// The labels of blocks that have ended and go on with a label: not where constants close the way.
    before: HashMap<u32, HashSet<u32>>,
    /// How many branches to each label are in blocks that have not ended.
    awaited: HashMap<u32, usize>,
}

/// The labels that a branch may go to.
fn targets(op: Option<Op>, operands: &[u32]) -> Vec<u32> {
    match (op, operands) {
        (Some(Op::Branch), [to]) => vec![*to],
        (Some(Op::BranchConditional), [_, yes, no, ..]) => vec![*yes, *no],
        (Some(Op::Switch), [_, otherwise, cases @ ..]) => {
            cases.chunks_exact(2).map(|pair| pair[1]).chain([*otherwise]).collect()
        }
        _ => Vec::new(),
    }
}

fn edge(label: u32) -> Edge {
    Edge { to: label as usize, moves: Vec::new() }
}

fn jump(to: usize) -> End {
    End { otherwise: Some(Edge { to, moves: Vec::new() }), ..End::default() }
}

/// The end of a block that leaves the function: to where it was called, if it was.
fn leaving(back: bool) -> End {
    if back { jump(BACK) } else { End::default() }
}

impl Builder<'_> {
    /// Decodes the function that the kernel begins with, and what it calls.
    pub(super) fn kernel(&mut self, entry: u32) -> Decoded<()> {
        self.begin_block();
        self.begin("OpVariable".into());
        for (first, count) in self.private.clone() {
            self.act(Act::Begin(first, count));
        }
        for (d, a) in self.initial.clone() {
            self.act(Act::Move(d, a));
        }
        for instruction in self.functions.values().flat_map(|range| &self.list[range.clone()]) {
            let first = match instruction.op {
                Some(Op::Line | Op::NoLine | Op::Label) => continue,
                Some(Op::Store | Op::BranchConditional | Op::Switch | Op::ReturnValue) => 0,
                _ => 2,
            };
            self.taken.extend(instruction.operands.iter().skip(first));
        }
        self.function(entry, Vec::new(), None)
    }

    /// Begins a block, and returns its number.
    fn begin_block(&mut self) -> usize {
        self.blocks.push(Block::default());
        self.blocks.len() - 1
    }

    /// Ends the last block.
    fn end_block(&mut self, end: End, op: Op) {
        self.begin(format!("Op{op:?}"));
        if let Some(block) = self.blocks.last_mut() {
            block.end = end;
            block.at.push(self.site);
        }
    }

    /// Decodes a function after the last block, which goes on with it. What it returns goes to these registers, and
    /// it goes on with a new block; none where it is the kernel.
    fn function(&mut self, id: u32, arguments: Vec<Value>, result: Option<&[u32]>) -> Decoded<()> {
        let range = self.functions.get(&id).cloned().ok_or_else(|| format!("there is no function %{id}"))?;
        if self.local.len() >= MOST_CALLS || self.blocks.len() > MOST_BLOCKS {
            return Err("its functions call each other too often".into());
        }
        self.local.push(HashMap::new());
        let (start, mut arguments, mut frame) = (self.blocks.len(), arguments.into_iter(), Frame::default());
        for instruction in &self.list[range.clone()] {
            let labels = targets(instruction.op, instruction.operands);
            labels.into_iter().for_each(|label| *frame.awaited.entry(label).or_default() += 1);
        }
        for at in range {
            let instruction = self.list[at];
            let op = instruction.op.ok_or("it has an instruction that is not known")?;
            match (op, instruction.operands) {
                (Op::Line, [file, line, ..]) => self.line = (*file, *line),
                // An instruction without a line of its own has that of the last one before it.
                (Op::NoLine, _) => {}
                (Op::FunctionParameter, [_, id]) => {
                    let argument = arguments.next().ok_or("a call has too few arguments")?;
                    self.set(*id, argument);
                }
                (Op::Label, [label]) => self.label(*label, &mut frame)?,
                (op, _) if !frame.open => return Err(format!("it has Op{op:?} outside of a block")),
                (op, operands) => {
                    self.blocks.last_mut().into_iter().for_each(|block| block.length += 1);
                    self.statement(op, operands, &mut frame, result)?;
                }
            }
            self.made += 1;
            self.is_small()?;
        }
        if frame.open || frame.first.is_empty() {
            return Err(format!("function %{id} does not end"));
        }
        self.link(&frame)?;
        self.local.pop();
        if result.is_some() {
            let back = self.begin_block();
            for block in &mut self.blocks[start..back] {
                let leaving = block.end.edges_mut().filter(|edge| edge.to == BACK);
                leaving.for_each(|edge| edge.to = back);
            }
            if start > 0 {
                self.blocks[start - 1].merges.push(back);
            }
        }
        Ok(())
    }

    /// Begins the block of a label.
    fn label(&mut self, label: u32, frame: &mut Frame) -> Decoded<()> {
        let block = self.begin_block();
        if frame.first.is_empty() {
            self.begin("OpLabel".into());
            self.blocks[block - 1].end = jump(block);
            self.blocks[block - 1].at.push(self.site);
        }
        let twice = frame.first.insert(label, block).is_some();
        if twice || std::mem::replace(&mut frame.open, true) {
            return Err(format!("block %{label} begins twice, or within another one"));
        }
        frame.label = label;
        Ok(())
    }

    /// Decodes an instruction of a function's body.
    fn statement(&mut self, op: Op, operands: &[u32], frame: &mut Frame, result: Option<&[u32]>) -> Decoded<()> {
        let merges = std::mem::take(&mut frame.merges);
        if !merges.is_empty() && !matches!(op, Op::Branch | Op::BranchConditional | Op::Switch) {
            return Err(format!("it has Op{op:?} where ways have to part that meet again"));
        }
        let mut end = match (op, operands) {
            (Op::Phi, [ty, id, from @ ..]) => return self.phi((*ty, *id), from, frame),
            (Op::LoopMerge, [merge, on, ..]) => {
                frame.merges = vec![*merge, *on];
                return Ok(());
            }
            (Op::SelectionMerge, [merge, ..]) => {
                frame.merges = vec![*merge];
                return Ok(());
            }
            (Op::FunctionCall, [ty, id, function, arguments @ ..]) => {
                return self.call((*ty, *id), *function, arguments);
            }
            (Op::Branch, [to]) => jump(*to as usize),
            (Op::BranchConditional, [on, yes, no, ..]) => {
                let on = self.single(*on)?;
                match self.constant(on).filter(|known| !is_undefined(*known)) {
                    Some(known) => jump(if known == 0 { *no } else { *yes } as usize),
                    None => End { on, cases: vec![(0, edge(*no))], otherwise: Some(edge(*yes)) },
                }
            }
            (Op::Switch, [on, otherwise, cases @ ..]) => {
                let cases = cases.chunks_exact(2).map(|pair| (pair[0], edge(pair[1]))).collect();
                End { on: self.single(*on)?, cases, otherwise: Some(edge(*otherwise)) }
            }
            (Op::ReturnValue, [value]) => {
                self.begin("OpReturnValue".into());
                for (d, a) in result.unwrap_or_default().iter().copied().zip(self.numbers(*value)?) {
                    self.act(Act::Move(d, a));
                }
                leaving(result.is_some())
            }
            (Op::Return | Op::Unreachable, _) => leaving(result.is_some()),
            _ => return self.instruction(op, operands),
        };
        frame.open = false;
        if matches!(op, Op::Branch | Op::BranchConditional | Op::Switch) {
            // A block may stand before those that lead to it.
            let awaited = frame.awaited.get(&frame.label).is_some_and(|count| *count > 0);
            let reached = awaited || frame.first.len() == 1 || frame.before.contains_key(&frame.label);
            for label in targets(Some(op), operands) {
                frame.awaited.entry(label).and_modify(|count| *count -= 1);
            }
            for edge in end.edges_mut().filter(|_| reached) {
                frame.before.entry(edge.to as u32).or_default().insert(frame.label);
            }
            frame.ends.push((self.blocks.len() - 1, frame.label, merges));
        }
        self.end_block(end, op);
        Ok(())
    }

    /// Decodes a choice by the block before.
    fn phi(&mut self, (ty, id): (u32, u32), from: &[u32], frame: &mut Frame) -> Decoded<()> {
        let count = self.types.count(ty)?;
        self.made += from.len();
        // What comes by one way only is no choice. A block that has not ended may come back to this one.
        let ended = |label: u32| frame.before.get(&frame.label).is_some_and(|before| before.contains(&label));
        let comes = |label: u32| ended(label) || label == frame.label || !frame.first.contains_key(&label);
        if let [only] = from.chunks_exact(2).filter(|pair| comes(pair[1])).collect::<Vec<_>>()[..]
            && ended(only[1])
        {
            let numbers = part_of(&self.numbers(only[0])?, 0, count)?;
            self.set(id, Value::Numbers(ty, numbers));
            return Ok(());
        }
        let registers = self.new_value(ty)?;
        self.set(id, Value::Numbers(ty, registers.clone()));
        let from = from.chunks_exact(2).map(|pair| (pair[1], pair[0])).collect();
        frame.phis.entry(frame.label).or_default().push(Phi { registers, from });
        Ok(())
    }

    /// Decodes a function in place of its call.
    fn call(&mut self, (ty, id): (u32, u32), function: u32, arguments: &[u32]) -> Decoded<()> {
        if arguments.len() > MOST_ARGUMENTS {
            return Err(format!("a call has more than {MOST_ARGUMENTS} arguments"));
        }
        let arguments = arguments.iter().map(|id| self.value(*id).cloned()).collect::<Decoded<Vec<_>>>()?;
        let registers = self.new_value(ty)?;
        let line = self.line;
        self.function(function, arguments, Some(&registers))?;
        self.line = line;
        self.set(id, Value::Numbers(ty, registers));
        Ok(())
    }

    /// Has the edges of a function's blocks lead to blocks, with the moves of phis.
    fn link(&mut self, frame: &Frame) -> Decoded<()> {
        let place = |label: &u32| {
            let found = frame.first.get(label);
            found.copied().ok_or_else(|| format!("there is no block %{label}"))
        };
        for (block, from, merges) in &frame.ends {
            let mut end = self.blocks[*block].end.clone();
            for edge in end.edges_mut() {
                let (label, mut moves) = (edge.to as u32, Vec::new());
                for phi in frame.phis.get(&label).into_iter().flatten() {
                    let value = phi.from.get(from).ok_or("a phi lacks a block")?;
                    moves.extend(phi.registers.iter().copied().zip(self.numbers(*value)?));
                }
                self.made += 1 + moves.len();
                self.is_small()?;
                *edge = Edge { to: place(&label)?, moves: self.at_once(moves) };
            }
            let merges = merges.iter().map(place).collect::<Decoded<Vec<_>>>()?;
            self.blocks[*block].merges.extend(merges);
            self.blocks[*block].end = end;
        }
        Ok(())
    }

    /// Moves that happen at once as moves one after the other.
    fn at_once(&mut self, mut moves: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
        moves.retain(|(d, a)| d != a);
        let mut changed = HashSet::new();
        let early = |(d, a): &(u32, u32)| {
            let before = changed.contains(a);
            changed.insert(*d);
            before
        };
        if !moves.iter().any(early) {
            return moves;
        }
        let first = self.registers(moves.len() as u32);
        let out = (first..).zip(&moves).map(|(between, (_, a))| (between, *a));
        let back = (first..).zip(&moves).map(|(between, (d, _))| (*d, between));
        out.chain(back).collect()
    }
}
