//! A kernel as the interpreter runs it: instructions on registers, in blocks whose order is the order of execution.
//!
//! Every number of the kernel has a register, of one word for each invocation of the group: `n` registers for a vector
//! of `n`. What only renames numbers, such as taking a component, has no instruction here.

/// A result, or what the interpreter has not got, or what is wrong with a module.
pub(super) type Decoded<T> = Result<T, String>;

/// A function of one number.
pub(super) type One = fn(u32) -> u32;
/// A function of two numbers.
pub(super) type Two = fn(u32, u32) -> u32;
/// A function of three numbers.
pub(super) type Three = fn(u32, u32, u32) -> u32;

/// What an invocation does; `d` is the register that takes the result.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act {
    One {
        f: One,
        d: u32,
        a: u32,
    },
    Two {
        f: Two,
        d: u32,
        a: u32,
        b: u32,
    },
    Three {
        f: Three,
        d: u32,
        a: u32,
        b: u32,
        c: u32,
    },
    Move {
        d: u32,
        a: u32,
    },
    Select {
        d: u32,
        on: u32,
        yes: u32,
        no: u32,
    },
    /// Where a pointer points to: an entry of [`Code::chains`].
    Chain(u32),
    /// Entries of [`Code::accesses`].
    Load(u32),
    Store(u32),
    /// An entry of [`Code::atomics`].
    Atomic(u32),
    /// How many elements of this many words the buffer has from this word on.
    Length {
        d: u32,
        buffer: u32,
        first: u32,
        stride: u32,
    },
    /// A barrier of a scope, and what memory it orders.
    Barrier {
        scope: u32,
        semantics: u32,
    },
    /// The order of memory only.
    Fence {
        scope: u32,
        semantics: u32,
    },
    /// An entry of [`Code::teams`].
    Team(u32),
    /// A variable begins its life without a value.
    Begin {
        first: u32,
        count: u32,
    },
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
    Apply(Two),
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
    Take(Two),
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
    Fold(Two, u32, Among),
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

/// How a block ends.
#[derive(Clone, Debug)]
pub(super) enum End {
    Jump(Edge),
    Branch { on: u32, yes: Edge, no: Edge },
    Switch { on: u32, cases: Vec<(u32, Edge)>, otherwise: Edge },
    Return,
}

impl End {
    /// The edges to other blocks.
    pub(super) fn edges_mut(&mut self) -> Vec<&mut Edge> {
        match self {
            Self::Jump(edge) => vec![edge],
            Self::Branch { yes, no, .. } => vec![yes, no],
            Self::Switch { cases, otherwise, .. } => {
                cases.iter_mut().map(|(_, edge)| edge).chain([otherwise]).collect()
            }
            Self::Return => Vec::new(),
        }
    }
}

/// A block.
#[derive(Debug)]
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
    /// Numbers of built-in values, and the first register of each.
    pub(super) inputs: Vec<(u32, u32)>,
    pub(super) chains: Vec<Chain>,
    pub(super) accesses: Vec<Access>,
    pub(super) atomics: Vec<Atomic>,
    pub(super) teams: Vec<Team>,
    pub(super) variables: Vec<Variable>,
    /// The binding of each buffer.
    pub(super) buffers: Vec<u32>,
    /// Words of the group's memory.
    pub(super) shared: u32,
    /// Whether results depend on the order in which groups run: it uses what atomic operations return.
    pub(super) ordered: bool,
}
