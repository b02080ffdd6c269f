//! The functions of a module as blocks. What a function calls is decoded in place of the call.

use std::collections::HashMap;

use spirq::spirv::Op;

use super::builder::{Builder, Value};
use super::code::{Act, Block, Decoded, Edge, End};

/// Where an edge leads that leaves the function, until the block after the call is there.
const BACK: usize = usize::MAX;
/// Most calls within each other; SPIR-V has no recursion.
const MOST_CALLS: usize = 64;
/// Most blocks of a kernel.
const MOST_BLOCKS: usize = 1 << 17;
/// Most registers of a kernel.
const MOST_REGISTERS: u32 = 1 << 21;

/// The numbers of a phi, and its value by the block before: an id and a label.
struct Phi {
    label: u32,
    registers: Vec<u32>,
    from: Vec<(u32, u32)>,
}

/// A function as it is being decoded. Until it ends, edges and merges of its blocks lead to labels.
#[derive(Default)]
struct Frame {
    /// The first block of each label.
    first: HashMap<u32, usize>,
    /// Its blocks that end by an instruction of its own, and the label each belongs to.
    ends: Vec<(usize, u32)>,
    phis: Vec<Phi>,
    label: u32,
}

fn edge(label: u32) -> Edge {
    Edge { to: label as usize, moves: Vec::new() }
}

impl Builder<'_> {
    /// Decodes the function that the kernel begins with, and what it calls.
    pub(super) fn kernel(&mut self, entry: u32) -> Decoded<()> {
        self.begin_block();
        let site = self.site("OpVariable".into());
        for (first, count) in self.private.clone() {
            self.act(Act::Begin { first, count }, site);
        }
        for (d, a) in self.initial.clone() {
            self.act(Act::Move { d, a }, site);
        }
        self.function(entry, Vec::new(), None)
    }

    /// Begins a block, and returns its number.
    fn begin_block(&mut self) -> usize {
        let empty = Block { acts: Vec::new(), at: Vec::new(), end: End::Return, merges: Vec::new(), length: 0 };
        self.blocks.push(empty);
        self.blocks.len() - 1
    }

    /// Ends the last block.
    fn end_block(&mut self, end: End, op: Op) {
        let site = self.site(format!("Op{op:?}"));
        if let Some(block) = self.blocks.last_mut() {
            block.end = end;
            block.at.push(site);
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
                (Op::Label, [label]) => {
                    let first = frame.first.is_empty();
                    let block = self.begin_block();
                    if first {
                        let end = End::Jump(Edge { to: block, moves: Vec::new() });
                        let site = self.site("OpLabel".into());
                        self.blocks[block - 1].end = end;
                        self.blocks[block - 1].at.push(site);
                    }
                    frame.label = *label;
                    frame.first.insert(*label, block);
                }
                (op, operands) => {
                    self.blocks.last_mut().into_iter().for_each(|block| block.length += 1);
                    self.statement(op, operands, &mut frame, result)?;
                    if self.code.registers > MOST_REGISTERS {
                        return Err("it has too many numbers".into());
                    }
                }
            }
        }
        self.link(&frame)?;
        self.local.pop();
        if result.is_some() {
            let back = self.begin_block();
            for block in &mut self.blocks[start..back] {
                let leaving = block.end.edges_mut().into_iter().filter(|edge| edge.to == BACK);
                leaving.for_each(|edge| edge.to = back);
            }
            if start > 0 {
                self.blocks[start - 1].merges.push(back);
            }
        }
        Ok(())
    }

    /// Decodes an instruction of a function's body.
    fn statement(&mut self, op: Op, operands: &[u32], frame: &mut Frame, result: Option<&[u32]>) -> Decoded<()> {
        let end = match (op, operands) {
            (Op::Phi, [ty, id, from @ ..]) => {
                let count = self.types.count(*ty)?;
                let first = self.registers(count);
                let registers: Vec<u32> = (first..first + count).collect();
                self.set(*id, Value::Numbers(*ty, registers.clone()));
                let from = from.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
                frame.phis.push(Phi { label: frame.label, registers, from });
                return Ok(());
            }
            (Op::LoopMerge, [merge, on, ..]) => return self.merges(&[*merge, *on]),
            (Op::SelectionMerge, [merge, ..]) => return self.merges(&[*merge]),
            (Op::FunctionCall, [ty, id, function, arguments @ ..]) => {
                return self.call((*ty, *id), *function, arguments);
            }
            (Op::Branch, [to]) => End::Jump(edge(*to)),
            (Op::BranchConditional, [on, yes, no, ..]) => {
                End::Branch { on: self.single(*on)?, yes: edge(*yes), no: edge(*no) }
            }
            (Op::Switch, [on, otherwise, cases @ ..]) => {
                let cases = cases.chunks_exact(2).map(|pair| (pair[0], edge(pair[1]))).collect();
                End::Switch { on: self.single(*on)?, cases, otherwise: edge(*otherwise) }
            }
            (Op::ReturnValue, [value]) => {
                let site = self.site("OpReturnValue".into());
                for (d, a) in result.unwrap_or_default().iter().copied().zip(self.numbers(*value)?) {
                    self.act(Act::Move { d, a }, site);
                }
                self.leave(op, result.is_some());
                return Ok(());
            }
            (Op::Return | Op::Unreachable, _) => {
                self.leave(op, result.is_some());
                return Ok(());
            }
            _ => return self.instruction(op, operands),
        };
        frame.ends.push((self.blocks.len() - 1, frame.label));
        self.end_block(end, op);
        Ok(())
    }

    /// Ends a block that leaves the function.
    fn leave(&mut self, op: Op, back: bool) {
        let end = if back { End::Jump(Edge { to: BACK, moves: Vec::new() }) } else { End::Return };
        self.end_block(end, op);
    }

    /// Notes where the ways of the last block meet: labels.
    fn merges(&mut self, labels: &[u32]) -> Decoded<()> {
        let block = self.blocks.last_mut().ok_or("a merge stands in no block")?;
        block.merges = labels.iter().map(|label| *label as usize).collect();
        Ok(())
    }

    /// Decodes a function in place of its call.
    fn call(&mut self, (ty, id): (u32, u32), function: u32, arguments: &[u32]) -> Decoded<()> {
        let arguments = arguments.iter().map(|id| self.value(*id).cloned()).collect::<Decoded<Vec<_>>>()?;
        let count = self.types.count(ty)?;
        let first = self.registers(count);
        let registers: Vec<u32> = (first..first + count).collect();
        let line = self.line;
        self.function(function, arguments, Some(&registers))?;
        self.line = line;
        self.set(id, Value::Numbers(ty, registers));
        Ok(())
    }

    /// Has the edges of a function's blocks lead to blocks, with the moves of phis.
    fn link(&mut self, frame: &Frame) -> Decoded<()> {
        let place = |label: usize| {
            let found = u32::try_from(label).ok().and_then(|label| frame.first.get(&label));
            found.copied().ok_or_else(|| format!("there is no block %{label}"))
        };
        for (block, from) in &frame.ends {
            let mut end = self.blocks[*block].end.clone();
            for edge in end.edges_mut() {
                let mut moves = Vec::new();
                for phi in frame.phis.iter().filter(|phi| phi.label as usize == edge.to) {
                    let (value, _) = phi.from.iter().find(|(_, label)| label == from).ok_or("a phi lacks a block")?;
                    moves.extend(phi.registers.iter().copied().zip(self.numbers(*value)?));
                }
                *edge = Edge { to: place(edge.to)?, moves: self.at_once(moves) };
            }
            let merges = self.blocks[*block].merges.iter().map(|label| place(*label)).collect::<Decoded<Vec<_>>>()?;
            (self.blocks[*block].end, self.blocks[*block].merges) = (end, merges);
        }
        Ok(())
    }

    /// Moves that happen at once as moves one after the other.
    fn at_once(&mut self, mut moves: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
        moves.retain(|(d, a)| d != a);
        let early = |(k, (_, a)): (usize, &(u32, u32))| moves[..k].iter().any(|(d, _)| d == a);
        if !moves.iter().enumerate().any(early) {
            return moves;
        }
        let first = self.registers(moves.len() as u32);
        let out = (first..).zip(&moves).map(|(between, (_, a))| (between, *a));
        let back = (first..).zip(&moves).map(|(between, (d, _))| (*d, between));
        out.chain(back).collect()
    }
}
