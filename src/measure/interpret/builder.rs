//! From a module of SPIR-V to a kernel that can be run: what the module declares.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use spirq::spirv::{BuiltIn, Decoration, ExecutionMode, Op, StorageClass};

use super::code::{Act, Block, Code, Decoded, Pointer, Root, Site, Variable};
use super::types::{Type, Types};
use crate::gpu::{Instruction, instructions, text};
use crate::layout::BUFFER_IDS;

/// What an id stands for.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// Its type, and the registers of its numbers.
    Numbers(u32, Vec<u32>),
    Pointer(Pointer),
}

/// A module that is being decoded.
#[derive(Default)]
pub(super) struct Builder<'a> {
    pub(super) list: Vec<Instruction<'a>>,
    pub(super) types: Types,
    /// The instructions of each function.
    pub(super) functions: HashMap<u32, Range<usize>>,
    global: HashMap<u32, Value>,
    /// The ids of functions that are being decoded, the innermost last.
    pub(super) local: Vec<HashMap<u32, Value>>,
    pub(super) code: Code,
    pub(super) blocks: Vec<Block>,
    /// The register of each number that is known, and the number in each such register.
    constants: HashMap<u32, u32>,
    known: HashMap<u32, u32>,
    /// Names of ids, and texts.
    names: HashMap<u32, String>,
    /// The instruction set GLSL.std.450, and sets that have no meaning.
    pub(super) glsl: u32,
    pub(super) silent: Vec<u32>,
    /// The file, an id, and the line of the next instruction.
    pub(super) line: (u32, u32),
    sites: HashMap<Site, u32>,
    /// The place of the instruction at hand.
    pub(super) site: u32,
    /// The first register of variables of the whole module that an invocation has for itself, and how many there are.
    pub(super) private: Vec<(u32, u32)>,
    /// Variables that have a value at first: registers, and those of the value.
    pub(super) initial: Vec<(u32, u32)>,
    /// What instructions of functions take: their operands, be they ids or not.
    pub(super) taken: HashSet<u32>,
    /// How many instructions, numbers of values and edges have been made.
    pub(super) made: usize,
    /// Whether sums take products in one step where nothing forbids it, and whether the instruction at hand may.
    pub(super) may_contract: bool,
    pub(super) contracts: bool,
    /// Products that sums may take: by their register, those of the factors.
    pub(super) products: HashMap<u32, (u32, u32)>,
}

/// The kernel of a module, with these values of specialization constants.
pub(super) fn decoded(words: &[u32], special: &BTreeMap<u32, u32>, may_contract: bool) -> Decoded<Code> {
    let mut builder = Builder { list: instructions(words).collect(), may_contract, ..Builder::default() };
    let entry = builder.declarations(special)?;
    builder.kernel(entry)?;
    let Builder { mut code, blocks, known, .. } = builder;
    code.blocks = super::flow::ordered(blocks)?;
    code.constants = known.into_iter().collect();
    Ok(code)
}

/// Most words that a group shares.
const MOST_SHARED: u32 = 1 << 16;
/// Most registers of a kernel.
const MOST_REGISTERS: u32 = 1 << 21;
/// Most instructions, numbers of values and edges that are made of a module.
const MOST_MADE: usize = 1 << 24;

/// A part of a value, from this number on.
pub(super) fn part_of(all: &[u32], first: usize, count: u32) -> Decoded<Vec<u32>> {
    let part = all.get(first..).and_then(|rest| rest.get(..count as usize));
    part.map(<[u32]>::to_vec).ok_or_else(|| "it takes a part that a value does not have".into())
}

/// The beginning of a name, which may be a whole source.
fn name_in(words: &[u32]) -> String {
    text(&words[..words.len().min(256)])
}

/// The name of the buffer that is bound at a number.
fn buffer_name(binding: u32) -> String {
    let known = BUFFER_IDS.get(binding as usize);
    known.map_or_else(|| format!("binding {binding}"), |id| id.spec().name.into())
}

impl<'a> Builder<'a> {
    /// Reads all that comes before functions, and where these are; returns the function that the kernel begins with.
    fn declarations(&mut self, special: &BTreeMap<u32, u32>) -> Decoded<u32> {
        let list = self.list.clone();
        let (mut entry, mut size, mut function) = (None, [1; 3], None);
        let mut by_ids = None;
        for (at, instruction) in list.iter().enumerate() {
            let operands = instruction.operands;
            match (instruction.op, operands) {
                (Some(Op::EntryPoint), [_, id, ..]) => entry = Some(*id),
                (Some(Op::ExecutionMode), [_, mode, x, y, z]) if *mode == ExecutionMode::LocalSize as u32 => {
                    size = [*x, *y, *z];
                }
                (Some(Op::ExecutionModeId), [_, mode, x, y, z]) if *mode == ExecutionMode::LocalSizeId as u32 => {
                    by_ids = Some([*x, *y, *z]);
                }
                (Some(Op::ExtInstImport), [id, name @ ..]) => match name_in(name).as_str() {
                    "GLSL.std.450" => self.glsl = *id,
                    name if name.starts_with("NonSemantic.") => self.silent.push(*id),
                    name => return Err(format!("it has the instruction set {name}")),
                },
                (Some(Op::Name | Op::String), [id, name @ ..]) => drop(self.names.insert(*id, name_in(name))),
                (Some(Op::Decorate | Op::MemberDecorate), _) => self.types.decorate(*instruction),
                (Some(Op::Function), [_, id, ..]) => function = Some((*id, at + 1)),
                (Some(Op::FunctionEnd), _) => {
                    let (id, first) = function.take().ok_or("a function ends that has not begun")?;
                    self.functions.insert(id, first..at);
                }
                (Some(op), [id, ..]) if (Op::TypeVoid..=Op::TypeFunction).contains(&op) => {
                    let length = match (op, operands) {
                        (Op::TypeArray, [.., length]) => self.single(*length).ok().and_then(|own| self.constant(own)),
                        _ => None,
                    };
                    let length = length.ok_or_else(|| format!("the length of array %{id} is no constant"));
                    self.types.declare(op, operands, length)?;
                }
                (Some(op), [ty, id, rest @ ..]) if function.is_none() => self.declare(op, *ty, *id, rest, special)?,
                (None, _) if function.is_none() => return Err("it has an instruction that is not known".into()),
                _ => {}
            }
        }
        if let Some(ids) = by_ids {
            for (size, id) in size.iter_mut().zip(ids) {
                *size = self.constant(self.single(id)?).ok_or("the size of its groups is no constant")?;
            }
        }
        // A constant of this name says so, too, and has the last word.
        let declared = self
            .global
            .iter()
            .find(|(id, _)| self.types.decoration(**id, Decoration::BuiltIn) == Some(BuiltIn::WorkgroupSize as u32));
        if let Some((_, Value::Numbers(_, numbers))) = declared {
            let numbers = numbers.iter().map(|register| self.constant(*register));
            size = numbers.collect::<Option<Vec<u32>>>().and_then(|all| all.try_into().ok()).unwrap_or(size);
        }
        self.code.group = size;
        entry.ok_or_else(|| "it has no entry point".into())
    }

    /// Takes a constant or a variable of the module.
    fn declare(&mut self, op: Op, ty: u32, id: u32, rest: &[u32], special: &BTreeMap<u32, u32>) -> Decoded<()> {
        let given = self.types.decoration(id, Decoration::SpecId).and_then(|number| special.get(&number)).copied();
        let numbers = match (op, rest) {
            (Op::Constant | Op::SpecConstant, [value]) => vec![self.number(given.unwrap_or(*value))],
            (Op::Constant | Op::SpecConstant, _) => return Err("it has a constant that is not 32 bits wide".into()),
            (Op::ConstantTrue | Op::SpecConstantTrue, _) => vec![self.number(given.unwrap_or(1))],
            (Op::ConstantFalse | Op::SpecConstantFalse, _) => vec![self.number(given.unwrap_or(0))],
            (Op::ConstantNull, _) => vec![self.number(0); self.types.count(ty)? as usize],
            (Op::Undef, _) => self.undefined(ty)?,
            (Op::ConstantComposite | Op::SpecConstantComposite, parts) => self.whole(ty, parts)?,
            (Op::SpecConstantOp, [what, operands @ ..]) => {
                let what = Op::from_u32(*what).ok_or("it computes a constant in a way that is not known")?;
                self.computed(what, ty, operands)?
            }
            (Op::Variable, [_, initial @ ..]) => return self.variable(ty, id, initial),
            // What else comes before functions has no result.
            _ => return Ok(()),
        };
        self.set(id, Value::Numbers(ty, numbers));
        self.is_small()
    }

    /// The numbers of a value that is put together of these parts; an error if they are not as many as its type has.
    pub(super) fn whole(&self, ty: u32, parts: &[u32]) -> Decoded<Vec<u32>> {
        let (count, mut all) = (self.types.count(ty)? as usize, Vec::new());
        for part in parts {
            all.extend(self.numbers(*part)?);
            if all.len() > count {
                break;
            }
        }
        match all.len() {
            given if given == count => Ok(all),
            given => Err(format!("it makes {count} numbers of {given}{}", if given > count { " or more" } else { "" })),
        }
    }

    /// Fails where so much is made of a module that memory may not hold it.
    pub(super) fn is_small(&self) -> Decoded<()> {
        match self.code.registers > MOST_REGISTERS || self.made > MOST_MADE {
            true => Err("it has too many numbers".into()),
            false => Ok(()),
        }
    }

    /// Takes a variable of the whole module.
    fn variable(&mut self, ty: u32, id: u32, initial: &[u32]) -> Decoded<()> {
        let (class, to) = self.types.pointee(ty)?;
        let root = match class {
            StorageClass::StorageBuffer | StorageClass::Uniform => {
                let binding = self.types.decoration(id, Decoration::Binding).ok_or("a buffer has no binding")?;
                self.code.buffers.push(binding);
                Root::Buffer(self.code.buffers.len() as u32 - 1)
            }
            StorageClass::Workgroup => {
                let first = self.code.shared;
                self.code.shared = first.saturating_add(self.types.count(to)?);
                if self.code.shared > MOST_SHARED {
                    return Err("its groups share too much memory".into());
                }
                Root::Shared(first)
            }
            StorageClass::Private => {
                let count = self.types.count(to)?;
                let first = self.registers(count);
                self.private.push((first, count));
                Root::Registers(first)
            }
            StorageClass::Input => {
                let input = self.types.decoration(id, Decoration::BuiltIn);
                let input = input.ok_or("it has an input that is not built in")?;
                let count = self.types.count(to)?;
                let known = BuiltIn::from_u32(input).filter(|known| numbers_of(*known) == count);
                let known = known.ok_or_else(|| format!("it has {count} numbers for the built-in value {input}"))?;
                let first = self.registers(count);
                self.code.inputs.push((known, first, count));
                Root::Registers(first)
            }
            StorageClass::PushConstant => {
                let count = self.types.words(to, true)?.into_iter().max().map_or(0, |last| last + 1);
                let first = self.registers(count);
                self.code.pushed = (first, count);
                Root::Registers(first)
            }
            other => return Err(format!("it has a variable of storage class {other:?}")),
        };
        let pointer = self.pointer(id, root, to)?;
        if let ([value], Root::Registers(first)) = (initial, root) {
            self.initial.extend((first..).zip(self.numbers(*value)?));
        }
        self.set(id, Value::Pointer(pointer));
        self.is_small()
    }

    /// A pointer to a variable, which is added to the list.
    pub(super) fn pointer(&mut self, id: u32, root: Root, to: u32) -> Decoded<Pointer> {
        let laid = matches!(root, Root::Buffer(_));
        // Buffers are structs of one array mostly; elements are those of the array.
        let mut of = to;
        while let Type::Struct(members) = self.types.get(of)?
            && let [member] = members[..]
        {
            of = member;
        }
        let (stride, _, count) = self.types.stride(of, laid).unwrap_or((1, 0, 1));
        let own = self.names.get(&id).filter(|name| !name.is_empty()).cloned();
        let name = match root {
            Root::Buffer(buffer) => buffer_name(self.code.buffers[buffer as usize]),
            _ => own.unwrap_or_else(|| format!("%{id}")),
        };
        self.code.variables.push(Variable { name, stride: stride.max(1), count });
        Ok(Pointer { root, variable: self.code.variables.len() as u32 - 1, ty: to, fixed: 0, rest: None })
    }

    /// New registers, the first of so many.
    pub(super) fn registers(&mut self, count: u32) -> u32 {
        let first = self.code.registers;
        self.code.registers = first.saturating_add(count);
        first
    }

    /// New registers for the numbers of a value of this type.
    pub(super) fn new_value(&mut self, ty: u32) -> Decoded<Vec<u32>> {
        let count = self.types.count(ty)?;
        let first = self.registers(count);
        Ok((first..first + count).collect())
    }

    /// The register of a number that is known.
    pub(super) fn number(&mut self, value: u32) -> u32 {
        if let Some(register) = self.constants.get(&value) {
            return *register;
        }
        let register = self.registers(1);
        self.constants.insert(value, register);
        self.known.insert(register, value);
        register
    }

    /// The number in a register, if it never changes.
    pub(super) fn constant(&self, register: u32) -> Option<u32> {
        self.known.get(&register).copied()
    }

    /// Registers of numbers that have no value.
    pub(super) fn undefined(&mut self, ty: u32) -> Decoded<Vec<u32>> {
        Ok(vec![self.number(super::memory::UNDEFINED); self.types.count(ty)? as usize])
    }

    /// What an id stands for.
    pub(super) fn value(&self, id: u32) -> Decoded<&Value> {
        let own = self.local.last().and_then(|local| local.get(&id));
        own.or_else(|| self.global.get(&id)).ok_or_else(|| format!("%{id} has no value"))
    }

    /// The type of a value, and the registers of its numbers.
    pub(super) fn typed(&self, id: u32) -> Decoded<(u32, Vec<u32>)> {
        match self.value(id)? {
            Value::Numbers(ty, numbers) => Ok((*ty, numbers.clone())),
            Value::Pointer(_) => Err(format!("%{id} is a pointer that is used as a number")),
        }
    }

    /// The registers of a value.
    pub(super) fn numbers(&self, id: u32) -> Decoded<Vec<u32>> {
        Ok(self.typed(id)?.1)
    }

    /// The only register of a value.
    pub(super) fn single(&self, id: u32) -> Decoded<u32> {
        self.numbers(id)?.first().copied().ok_or_else(|| format!("%{id} is empty"))
    }

    /// The pointer that an id stands for.
    pub(super) fn pointing(&self, id: u32) -> Decoded<Pointer> {
        match self.value(id)? {
            Value::Pointer(pointer) => Ok(pointer.clone()),
            Value::Numbers(..) => Err(format!("%{id} is no pointer")),
        }
    }

    /// Notes what an id of the function stands for, or of the module before there is one.
    pub(super) fn set(&mut self, id: u32, value: Value) {
        self.made += if let Value::Numbers(_, numbers) = &value { numbers.len() } else { 1 };
        self.local.last_mut().map_or(&mut self.global, |local| local).insert(id, value);
    }

    /// An instruction begins: what is made of it has its place in the sources.
    pub(super) fn begin(&mut self, instruction: String) {
        let file = self.names.get(&self.line.0).cloned().unwrap_or_default();
        // The build has its own folder for the layout.
        let file = if file.ends_with("/layout.glsl") { "layout.glsl".into() } else { file };
        let line = if file.is_empty() { 0 } else { self.line.1 };
        let site = Site { instruction, file, line };
        let places = &mut self.code.places;
        self.site = *self.sites.entry(site.clone()).or_insert_with(|| {
            places.push(site);
            places.len() as u32 - 1
        });
    }

    /// Adds an act of the instruction to the last block.
    pub(super) fn act(&mut self, act: Act) {
        self.made += 1;
        if let Some(block) = self.blocks.last_mut() {
            block.acts.push(act);
            block.at.push(self.site);
        }
    }
}

/// How many numbers a built-in value of compute has; 0 of all others.
fn numbers_of(input: BuiltIn) -> u32 {
    use BuiltIn as B;
    match input {
        B::WorkgroupId | B::NumWorkgroups | B::LocalInvocationId | B::GlobalInvocationId => 3,
        B::LocalInvocationIndex | B::SubgroupId | B::NumSubgroups => 1,
        B::SubgroupLocalInvocationId | B::SubgroupSize => 1,
        B::SubgroupEqMask | B::SubgroupGeMask | B::SubgroupGtMask | B::SubgroupLeMask | B::SubgroupLtMask => 4,
        _ => 0,
    }
}
