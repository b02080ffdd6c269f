//! The types of a module: how many numbers each has, and where in memory those are.

use std::collections::HashMap;

use spirq::spirv::{Decoration, Op, StorageClass};

use super::code::Decoded;
use crate::gpu::Instruction;

/// A type. Its parts are ids of types.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Type {
    Void,
    Bool,
    Int,
    Float,
    /// Vectors, matrices and arrays: the part, and how many of it.
    Vector(u32, u32),
    Matrix(u32, u32),
    Array(u32, u32),
    /// An array that ends where the buffer does.
    Open(u32),
    Struct(Vec<u32>),
    Pointer(u32, u32),
    Function,
}

/// A type that is declared.
struct Known {
    ty: Type,
    /// How many numbers it has; none where its values cannot be taken.
    count: Option<u32>,
    /// Where the numbers of each member of a struct begin.
    starts: Vec<u32>,
    /// How many types are within each other, this one included.
    depth: u32,
}

/// Most numbers of a value.
const MOST_NUMBERS: u32 = 1 << 16;
/// Most types within each other.
const MOST_DEPTH: u32 = 64;

/// The types of a module, and the decorations that lay them out.
#[derive(Default)]
pub(super) struct Types {
    types: HashMap<u32, Known>,
    /// The operand of a decoration, 0 where it has none: by what it decorates, and of a struct the member.
    decorations: HashMap<(u32, Option<u32>, u32), u32>,
}

impl Types {
    /// Takes a decoration.
    pub(super) fn decorate(&mut self, instruction: Instruction<'_>) {
        let (key, operand) = match (instruction.op, instruction.operands) {
            (Some(Op::Decorate), [id, what, operand @ ..]) => ((*id, None, *what), operand),
            (Some(Op::MemberDecorate), [id, member, what, operand @ ..]) => ((*id, Some(*member), *what), operand),
            _ => return,
        };
        self.decorations.insert(key, operand.first().copied().unwrap_or_default());
    }

    /// The operand of a decoration of an id.
    pub(super) fn decoration(&self, id: u32, what: Decoration) -> Option<u32> {
        self.decorations.get(&(id, None, what as u32)).copied()
    }

    fn member(&self, id: u32, member: u32, what: Decoration) -> Option<u32> {
        self.decorations.get(&(id, Some(member), what as u32)).copied()
    }

    /// Declares a type; `length` is that of an array.
    pub(super) fn declare(&mut self, op: Op, operands: &[u32], length: Decoded<u32>) -> Decoded<()> {
        let &[id, ref parts @ ..] = operands else { return Err("a type has no id".into()) };
        let declared = match (op, parts) {
            (Op::TypeVoid, _) => Type::Void,
            (Op::TypeBool, _) => Type::Bool,
            (Op::TypeInt, [32, _]) => Type::Int,
            (Op::TypeFloat, [32, ..]) => Type::Float,
            (Op::TypeInt | Op::TypeFloat, [bits, ..]) => return Err(format!("it has numbers of {bits} bits")),
            (Op::TypeVector, [of, count @ 2..=4]) => Type::Vector(*of, *count),
            (Op::TypeMatrix, [of, count @ 2..=4]) => Type::Matrix(*of, *count),
            (Op::TypeArray, [of, _]) => Type::Array(*of, length?),
            (Op::TypeRuntimeArray, [of]) => Type::Open(*of),
            (Op::TypeStruct, members) => Type::Struct(members.to_vec()),
            (Op::TypePointer, [class, to]) => Type::Pointer(*class, *to),
            (Op::TypeFunction, _) => Type::Function,
            _ => return Err(format!("it has the type Op{op:?}")),
        };
        // A type is made of types before it, so that none is made of itself.
        let parts = match &declared {
            Type::Vector(of, _) | Type::Matrix(of, _) | Type::Array(of, _) | Type::Open(of) => &[*of][..],
            Type::Struct(members) => members,
            _ => &[],
        };
        let known = parts.iter().map(|part| self.types.get(part)).collect::<Option<Vec<_>>>();
        let Some(known) = known.filter(|_| !self.types.contains_key(&id)) else {
            return Err(format!("type %{id} is not made of types before it"));
        };
        let depth = known.iter().map(|part| part.depth).max().unwrap_or_default() + 1;
        let (mut starts, mut all) = (Vec::new(), Some(0u32));
        for part in &known {
            starts.push(all.unwrap_or_default());
            all = all.zip(part.count).map(|(sum, count)| sum.saturating_add(count));
        }
        let count = match &declared {
            Type::Void => Some(0),
            Type::Bool | Type::Int | Type::Float => Some(1),
            Type::Vector(_, count) | Type::Matrix(_, count) | Type::Array(_, count) => {
                all.map(|all| all.saturating_mul(*count))
            }
            Type::Struct(_) => all,
            Type::Open(_) | Type::Pointer(..) | Type::Function => None,
        };
        if depth > MOST_DEPTH {
            return Err(format!("it has more than {MOST_DEPTH} types within each other"));
        }
        if count.is_some_and(|count| count > MOST_NUMBERS) {
            return Err("it has a value of more than 256 KiB".into());
        }
        self.types.insert(id, Known { ty: declared, count, starts, depth });
        Ok(())
    }

    fn known(&self, id: u32) -> Decoded<&Known> {
        self.types.get(&id).ok_or_else(|| format!("type {id} is not declared"))
    }

    /// The type of an id.
    pub(super) fn get(&self, id: u32) -> Decoded<&Type> {
        Ok(&self.known(id)?.ty)
    }

    /// The class and the type that a pointer type points to.
    pub(super) fn pointee(&self, id: u32) -> Decoded<(StorageClass, u32)> {
        match self.get(id)? {
            Type::Pointer(class, to) => {
                let known = StorageClass::from_u32(*class);
                Ok((known.ok_or_else(|| format!("it has the storage class {class}"))?, *to))
            }
            _ => Err(format!("type {id} is no pointer")),
        }
    }

    /// How many numbers a type has.
    pub(super) fn count(&self, id: u32) -> Decoded<u32> {
        let known = self.known(id)?;
        known.count.ok_or_else(|| format!("it takes a value of {:?}", known.ty))
    }

    /// Whether a value of this type is made of others that have names or indices: struct or array.
    pub(super) fn is_composite(&self, id: u32) -> bool {
        matches!(self.get(id), Ok(Type::Struct(_) | Type::Array(..)))
    }

    /// Whether it is a float, or a vector or matrix of these.
    pub(super) fn is_float(&self, id: u32) -> bool {
        match self.get(id) {
            Ok(Type::Float) => true,
            Ok(Type::Vector(of, _) | Type::Matrix(of, _)) => self.is_float(*of),
            _ => false,
        }
    }

    /// One part of a value: its type, and the number of the value that it begins with.
    pub(super) fn part(&self, id: u32, index: u32) -> Decoded<(u32, u32)> {
        let within = |count: u32| if index < count { Ok(()) } else { Err(format!("it takes part {index} of {count}")) };
        let known = self.known(id)?;
        match &known.ty {
            Type::Vector(of, count) | Type::Matrix(of, count) | Type::Array(of, count) => {
                within(*count)?;
                Ok((*of, index * self.count(*of)?))
            }
            Type::Struct(members) => {
                within(members.len() as u32)?;
                Ok((members[index as usize], known.starts[index as usize]))
            }
            other => Err(format!("it takes a part of {other:?}")),
        }
    }

    /// A member of a struct in memory, and its first word; `laid` where offsets are decorated.
    pub(super) fn member_at(&self, id: u32, member: u32, laid: bool) -> Decoded<(u32, u32)> {
        let Type::Struct(members) = self.get(id)? else { return Err("it takes a member of no struct".into()) };
        let ty = *members.get(member as usize).ok_or("it takes a member that a struct does not have")?;
        if !laid {
            return Ok((ty, self.part(id, member)?.1));
        }
        let own = |what| self.member(id, member, what);
        let offset = own(Decoration::Offset).ok_or("a struct in a buffer has no offsets")?;
        let rows = match self.get(ty)? {
            Type::Matrix(of, _) => self.count(*of)?,
            _ => 0,
        };
        if rows > 0 && (own(Decoration::RowMajor).is_some() || own(Decoration::MatrixStride) != Some(4 * rows)) {
            return Err("it has a matrix in a buffer that is not laid out by columns without gaps".into());
        }
        if offset.is_multiple_of(4) { Ok((ty, offset / 4)) } else { Err("a member begins within a word".into()) }
    }

    /// Words from one part of a vector, matrix or array in memory to the next, the part's type, and how many there are;
    /// `u32::MAX` in an open array.
    pub(super) fn stride(&self, id: u32, laid: bool) -> Decoded<(u32, u32, u32)> {
        let (of, count, is_array) = match self.get(id)? {
            Type::Vector(of, count) | Type::Matrix(of, count) => (*of, *count, false),
            Type::Array(of, count) => (*of, *count, true),
            Type::Open(of) => (*of, u32::MAX, true),
            other => return Err(format!("it takes an element of {other:?}")),
        };
        let decorated = self.decoration(id, Decoration::ArrayStride).filter(|_| laid && is_array);
        match decorated {
            Some(bytes) if bytes.is_multiple_of(4) => Ok((bytes / 4, of, count)),
            Some(bytes) => Err(format!("it has elements of {bytes} bytes")),
            None => Ok((self.count(of)?, of, count)),
        }
    }

    /// The word of each number of a value in memory.
    pub(super) fn words(&self, id: u32, laid: bool) -> Decoded<Vec<u32>> {
        let count = self.count(id)?;
        let mut found = Vec::with_capacity(count as usize);
        let far = || "it has a value that does not fit into memory".to_string();
        match self.get(id)? {
            _ if count == 0 => {}
            Type::Struct(members) => {
                for member in 0..members.len() as u32 {
                    let (ty, first) = self.member_at(id, member, laid)?;
                    for word in self.words(ty, laid)? {
                        found.push(word.checked_add(first).ok_or_else(far)?);
                    }
                }
            }
            Type::Vector(..) | Type::Matrix(..) | Type::Array(..) => {
                let (stride, of, count) = self.stride(id, laid)?;
                let part = self.words(of, laid)?;
                let place = |k: u32, word: u32| k.checked_mul(stride)?.checked_add(word);
                for k in 0..count {
                    found
                        .extend(part.iter().map(|word| place(k, *word)).collect::<Option<Vec<u32>>>().ok_or_else(far)?);
                }
            }
            _ => found.push(0),
        }
        Ok(found)
    }
}
