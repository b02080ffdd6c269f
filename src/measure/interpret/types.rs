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

/// The types of a module, and the decorations that lay them out.
#[derive(Default)]
pub(super) struct Types {
    types: HashMap<u32, Type>,
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

    /// Declares a type; `value` is the number that a constant has.
    pub(super) fn declare(&mut self, op: Op, operands: &[u32], value: impl Fn(u32) -> Decoded<u32>) -> Decoded<()> {
        let &[id, ref parts @ ..] = operands else { return Err("a type has no id".into()) };
        let declared = match (op, parts) {
            (Op::TypeVoid, _) => Type::Void,
            (Op::TypeBool, _) => Type::Bool,
            (Op::TypeInt, [32, _]) => Type::Int,
            (Op::TypeFloat, [32, ..]) => Type::Float,
            (Op::TypeInt | Op::TypeFloat, [bits, ..]) => return Err(format!("it has numbers of {bits} bits")),
            (Op::TypeVector, [of, count]) => Type::Vector(*of, *count),
            (Op::TypeMatrix, [of, count]) => Type::Matrix(*of, *count),
            (Op::TypeArray, [of, length]) => Type::Array(*of, value(*length)?),
            (Op::TypeRuntimeArray, [of]) => Type::Open(*of),
            (Op::TypeStruct, members) => Type::Struct(members.to_vec()),
            (Op::TypePointer, [class, to]) => Type::Pointer(*class, *to),
            (Op::TypeFunction, _) => Type::Function,
            _ => return Err(format!("it has the type Op{op:?}")),
        };
        // A type is made of types before it, so that none is made of itself.
        let parts = match &declared {
            Type::Vector(of, _) | Type::Matrix(of, _) | Type::Array(of, _) | Type::Open(of) => vec![*of],
            Type::Struct(members) => members.clone(),
            _ => Vec::new(),
        };
        if self.types.contains_key(&id) || !parts.iter().all(|part| self.types.contains_key(part)) {
            return Err(format!("type %{id} is not made of types before it"));
        }
        let is_open = |part: &u32| self.count(*part).is_err();
        let sized =
            !parts.iter().any(is_open) && !matches!(declared, Type::Pointer(..) | Type::Function | Type::Open(_));
        self.types.insert(id, declared);
        if sized { self.count(id).map(|_| ()) } else { Ok(()) }
    }

    /// The type of an id.
    pub(super) fn get(&self, id: u32) -> Decoded<&Type> {
        self.types.get(&id).ok_or_else(|| format!("type {id} is not declared"))
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
        const MOST: u32 = 1 << 16;
        let few = |all: Option<u32>| all.filter(|all| *all <= MOST).ok_or("it has a value of more than 256 KiB");
        let many = |of: u32, count: u32| Ok(few(self.count(of)?.checked_mul(count))?);
        match self.get(id)? {
            Type::Void => Ok(0),
            Type::Bool | Type::Int | Type::Float => Ok(1),
            Type::Vector(of, count) | Type::Matrix(of, count) | Type::Array(of, count) => many(*of, *count),
            Type::Struct(members) => {
                let add = |sum: u32, member: &u32| Ok(few(sum.checked_add(self.count(*member)?))?);
                members.iter().try_fold(0, add)
            }
            other => Err(format!("it takes a value of {other:?}")),
        }
    }

    /// Whether a value of this type is made of others that have names or indices: struct or array.
    pub(super) fn is_composite(&self, id: u32) -> bool {
        matches!(self.types.get(&id), Some(Type::Struct(_) | Type::Array(..)))
    }

    /// Whether it is a float, or a vector or matrix of these.
    pub(super) fn is_float(&self, id: u32) -> bool {
        match self.types.get(&id) {
            Some(Type::Float) => true,
            Some(Type::Vector(of, _) | Type::Matrix(of, _)) => self.is_float(*of),
            _ => false,
        }
    }

    /// One part of a value: its type, and the number of the value that it begins with.
    pub(super) fn part(&self, id: u32, index: u32) -> Decoded<(u32, u32)> {
        let within = |count: u32| if index < count { Ok(()) } else { Err(format!("it takes part {index} of {count}")) };
        match self.get(id)? {
            Type::Vector(of, count) | Type::Matrix(of, count) | Type::Array(of, count) => {
                within(*count)?;
                Ok((*of, index * self.count(*of)?))
            }
            Type::Struct(members) => {
                within(members.len() as u32)?;
                let before = members[..index as usize].iter().map(|member| self.count(*member));
                Ok((members[index as usize], before.sum::<Decoded<u32>>()?))
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
        let mut found = Vec::new();
        match self.get(id)? {
            Type::Struct(members) => {
                for member in 0..members.len() as u32 {
                    let (ty, first) = self.member_at(id, member, laid)?;
                    found.extend(self.words(ty, laid)?.iter().map(|word| first + word));
                }
            }
            Type::Vector(..) | Type::Matrix(..) | Type::Array(..) => {
                let (stride, of, count) = self.stride(id, laid)?;
                let part = self.words(of, laid)?;
                found.extend((0..count).flat_map(|k| part.iter().map(move |word| k * stride + word)));
            }
            _ => found.extend(0..self.count(id)?),
        }
        Ok(found)
    }
}
