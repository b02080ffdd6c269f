//! A kernel as the interpreter runs it: instructions on registers, in blocks whose order is the order of execution.
//!
//! Every number of the kernel has a register, of one word for each invocation of the group: `n` registers for a vector
//! of `n`. What only renames numbers, such as taking a component, has no instruction here.

use spirq::spirv::BuiltIn;

/// A result, or what the interpreter has not got, or what is wrong with a module.
pub(super) type Decoded<T> = Result<T, String>;

/// A function of two numbers.
pub(super) type OfTwo = fn(u32, u32) -> u32;

/// What an instruction computes of numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Function {
    One(fn(u32) -> u32),
    Two(OfTwo),
    Three(fn(u32, u32, u32) -> u32),
    /// The second number, or the third where the first is 0.
    Select,
}

impl Function {
    /// How many of its operands the result depends on, whatever their values are.
    pub(super) fn depends(self) -> usize {
        match self {
            Self::One(_) | Self::Select => 1,
            Self::Two(_) => 2,
            Self::Three(_) => 3,
        }
    }

    /// Its value.
    pub(super) fn value(self, [a, b, c]: [u32; 3]) -> u32 {
        match self {
            Self::One(f) => f(a),
            Self::Two(f) => f(a, b),
            Self::Three(f) => f(a, b, c),
            Self::Select if a == 0 => c,
            Self::Select => b,
        }
    }
}

/// What an invocation does. Numbers are registers where nothing else is said.
#[derive(Debug)]
pub(super) enum Act {
    /// The register that takes the result, and the operands.
    Compute(Function, u32, [u32; 3]),
    /// The first register takes what is in the second.
    Move(u32, u32),
    /// Where a pointer points to.
    Chain(Box<Chain>),
    Load(Box<Access>),
    Store(Box<Access>),
    Atomic(Box<Atomic>),
    /// The register takes how many elements a buffer has, an entry of [`Code::buffers`]: the word of the first one, and
    /// words from one to the next.
    Length(u32, u32, [u32; 2]),
    /// A barrier of a scope, and what memory it orders.
    Barrier(u32, u32),
    /// The order of memory only.
    Fence(u32, u32),
    Team(Box<Team>),
    /// A variable begins its life without a value: its first register, and how many there are.
    Begin(u32, u32),
}

/// Where a variable is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Root {
    /// A buffer: an entry of [`Code::buffers`].
    Buffer(u32),
    /// The group's memory, from this word on.
    Shared(u32),
    /// Registers, from this one on.
    Registers(u32),
}

/// What a pointer points to.
#[derive(Clone, Debug)]
pub(super) struct Pointer {
    pub(super) root: Root,
    /// The variable: an entry of [`Code::variables`].
    pub(super) variable: u32,
    /// The type of what it points to.
    pub(super) ty: u32,
    /// Its word from the variable's first, as far as that is known.
    pub(super) fixed: u32,
    /// The register of the rest.
    pub(super) rest: Option<u32>,
}

/// The rest of a pointer is [`BEYOND`] where an index is beyond the end of its array.
pub(super) const BEYOND: u32 = 0x8000_0000;

/// How the rest of a pointer is computed.
#[derive(Debug)]
pub(super) struct Chain {
    pub(super) d: u32,
    pub(super) base: Option<u32>,
    /// The register of each index, words from one element to the next, and the number of elements.
    pub(super) terms: Vec<(u32, u32, u32)>,
}

/// A value that is loaded or stored.
#[derive(Debug)]
pub(super) struct Access {
    pub(super) pointer: Pointer,
    /// The registers of its numbers.
    pub(super) registers: Vec<u32>,
    /// Their words from that of the pointer.
    pub(super) words: Vec<u32>,
    /// Whether it is a number or a vector of them, and no struct or array.
    pub(super) plain: bool,
    /// Whether it is made of floats.
    pub(super) floats: bool,
}

/// What an atomic operation does with the word.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    Load,
    Store,
    /// The word and the operand give the new word.
    Apply(OfTwo),
    /// The operand takes its place if it equals this register; if not, it is only loaded, with these semantics.
    Compare {
        with: u32,
        unequal: u32,
    },
}

/// An atomic operation.
#[derive(Debug)]
pub(super) struct Atomic {
    pub(super) pointer: Pointer,
    /// The register of the old word.
    pub(super) d: u32,
    /// The register of the operand.
    pub(super) a: u32,
    pub(super) change: Change,
    pub(super) semantics: u32,
}

/// An operation of a subgroup.
#[derive(Debug)]
pub(super) struct Team {
    pub(super) kind: Exchange,
    /// The registers of the result and of the value: one each, or four.
    pub(super) d: Vec<u32>,
    pub(super) a: Vec<u32>,
    /// The register of another operand.
    pub(super) b: Option<u32>,
}

/// How invocations of a subgroup exchange values.
#[derive(Clone, Copy, Debug)]
pub(super) enum Exchange {
    /// The value of the invocation that this gives, from the own number and the operand.
    Take(OfTwo),
    /// The value of the first one.
    First,
    Elect,
    All,
    Any,
    Equal,
    Ballot,
    /// The bit of a ballot at the own number, or at the operand.
    Bit,
    /// How many bits of a ballot are set among all, those up to the own one, or those before it.
    Count(Among),
    /// The number of the first or the last bit that is set.
    Lowest,
    Highest,
    /// What this function makes of all values, in their order, beginning with this number.
    Fold(OfTwo, u32, Among),
}

/// Of which invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Among {
    All,
    UpToOwn,
    BeforeOwn,
    /// Those of the own run of so many.
    Run(u32),
}

/// Where a block goes on, and what the numbers of its phis become: moves, in this order.
#[derive(Clone, Debug, Default)]
pub(super) struct Edge {
    pub(super) to: usize,
    pub(super) moves: Vec<(u32, u32)>,
}

/// How a block ends: a register, the edges that are taken where it has these values, and the one otherwise; the kernel
/// ends where there is none. A jump has no cases.
#[derive(Clone, Debug, Default)]
pub(super) struct End {
    pub(super) on: u32,
    pub(super) cases: Vec<(u32, Edge)>,
    pub(super) otherwise: Option<Edge>,
}

impl End {
    /// The edges to other blocks.
    pub(super) fn edges_mut(&mut self) -> impl Iterator<Item = &mut Edge> {
        self.cases.iter_mut().map(|(_, edge)| edge).chain(&mut self.otherwise)
    }
}

/// A block.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) acts: Vec<Act>,
    /// The place of each of them, and that of the block's end: entries of [`Code::places`].
    pub(super) at: Vec<u32>,
    pub(super) end: End,
    /// Where its branches meet, and where its loop goes on.
    pub(super) merges: Vec<usize>,
    /// Instructions of SPIR-V.
    pub(super) length: u64,
}

/// An instruction's place in the sources.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Site {
    /// The instruction, `OpLoad`.
    pub instruction: String,
    /// The file of GLSL, and the line; both empty where the module does not say.
    pub file: String,
    /// The line, counted from 1.
    pub line: u32,
}

impl std::fmt::Display for Site {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.file.is_empty() {
            true => write!(out, "{}, without a line", self.instruction),
            false => write!(out, "{}:{} ({})", self.file, self.line, self.instruction),
        }
    }
}

/// A variable.
#[derive(Clone, Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Words from one element of the buffer, or of the array, to the next.
    pub(super) stride: u32,
    /// How many elements it has; `u32::MAX` where its buffer says.
    pub(super) count: u32,
}

/// A kernel.
#[derive(Debug, Default)]
pub(super) struct Code {
    /// Its blocks; it begins with the first one, and of several in which invocations are, the first one runs.
    pub(super) blocks: Vec<Block>,
    pub(super) places: Vec<Site>,
    /// Invocations of a group, by dimension.
    pub(super) group: [u32; 3],
    /// How many registers it has.
    pub(super) registers: u32,
    /// Registers that never change, and their values.
    pub(super) constants: Vec<(u32, u32)>,
    /// The first register of the push constants, and how many there are.
    pub(super) pushed: (u32, u32),
    /// Built-in values: the first register of each, and how many it has.
    pub(super) inputs: Vec<(BuiltIn, u32, u32)>,
    pub(super) variables: Vec<Variable>,
    /// The binding of each buffer.
    pub(super) buffers: Vec<u32>,
    /// Words of the group's memory.
    pub(super) shared: u32,
    /// Whether results depend on the order in which groups run: it uses what atomic operations return.
    pub(super) ordered: bool,
}
