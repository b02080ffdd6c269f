//! A module that is to replace a kernel, made to fit what the program gives that kernel: specialization constants of
//! its own, and push constants beyond those that the program sets, become plain constants.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use spirq::spirv::{Decoration, Op, StorageClass};
use toml::Value;

use crate::error::{Input, Result};
use crate::gpu::pushed::{BAKED_ID, as_specialization};
use crate::gpu::reflect::Reflected;
use crate::gpu::spirv_module::{HEADER_WORDS, Instruction, append, instructions};

/// Most bytes of push constants, those included that the program does not set.
const MOST_PUSHED: u32 = 4096;

/// Values for constants of a user's kernel, from a file.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// The file.
    pub file: PathBuf,
    /// Name or id of a constant, its line in the file, and its value.
    pub values: Vec<(String, Option<usize>, Value)>,
}

/// The type of a specialization constant.
#[derive(Clone, Copy)]
enum Kind {
    Bool,
    Int { bits: u32, signed: bool },
    Float { bits: u32 },
}

/// A specialization constant of a module.
struct Scalar {
    name: String,
    kind: Kind,
}

/// What a file may set: its name, its id if it has one, and the specialization constants that it consists of.
struct Place {
    name: String,
    id: Option<u32>,
    parts: Vec<(u32, Kind)>,
}

/// The module with plain constants in place of those that the program does not set: they have the given values, or
/// their defaults; 0 for push constants. `fault` makes an error of what a module does that it must not.
pub(super) fn adapted(
    words: Vec<u32>,
    [own, right]: [&Reflected; 2],
    given: &Given,
    fault: &dyn Fn(String) -> Input,
) -> Result<Vec<u32>> {
    let set_by_program = |id: u32| right.names.contains_key(&id) || right.open.contains(&id);
    let scalars_of = |words: &[u32]| -> BTreeMap<u32, Scalar> {
        scalars(words).into_iter().filter(|(id, _)| !set_by_program(*id)).collect()
    };
    if let Some((id, scalar)) = scalars_of(&words).last_key_value().filter(|(id, _)| **id >= BAKED_ID) {
        let found = format!("has the specialization constant {} with the id {id}", scalar.name);
        return Err(fault(found).expected(format!("ids below {BAKED_ID}")).into());
    }
    let (members, pushed) = (members(&words), right.push_bytes);
    let words = if own.push_bytes > pushed {
        let some = Some(&words).filter(|_| own.push_bytes <= MOST_PUSHED);
        some.and_then(|words| as_specialization(words, pushed)).ok_or_else(|| {
            let found = format!("takes {} bytes of push constants, and the program sets {pushed}", own.push_bytes);
            let most = format!("at most {MOST_PUSHED} bytes");
            fault(found).expected(format!("members of 32-bit numbers beyond those, with constants for indices; {most}"))
        })?
    } else {
        words
    };
    let scalars = scalars_of(&words);
    let mut places: Vec<Place> = Vec::new();
    for (id, Scalar { name, kind }) in scalars.range(..BAKED_ID) {
        places.push(Place { name: name.clone(), id: Some(*id), parts: vec![(*id, *kind)] });
    }
    for (at, (name, offset)) in members.iter().enumerate().filter(|(_, (_, offset))| *offset >= pushed) {
        let first = |offset: u32| BAKED_ID + offset / 4;
        let own = first(*offset)..members.get(at + 1).map_or(u32::MAX, |(_, next)| first(*next));
        let parts = scalars.iter().filter(|(id, _)| own.contains(id)).map(|(id, scalar)| (*id, scalar.kind));
        places.push(Place { name: name.clone(), id: None, parts: parts.collect() });
    }
    let set: Vec<&String> =
        right.names.values().chain(members.iter().filter(|(_, at)| *at < pushed).map(|(name, _)| name)).collect();
    let values = given.of(&places, &set)?;
    Ok(frozen(&words, &scalars.into_keys().collect(), &values))
}

impl Given {
    /// The words of each constant that has a value, by specialization id; `set` are constants that the program sets.
    fn of(&self, places: &[Place], set: &[&String]) -> Result<BTreeMap<u32, Vec<u32>>> {
        let mut values = BTreeMap::new();
        for (key, line, value) in &self.values {
            let fault = |what: &str| Input { line: *line, ..Input::new(what).file(&self.file).key(key) };
            let place = places.iter().find(|p| p.name == *key || p.id.is_some_and(|id| id.to_string() == *key));
            let Some(place) = place else {
                let names: Vec<&str> = places.iter().map(|place| place.name.as_str()).collect();
                let expected = match names.as_slice() {
                    [] => "nothing: the kernel has no constants of its own".into(),
                    names => names.join(", "),
                };
                let what = match set.contains(&key) {
                    true => "the program sets this constant",
                    false => "no such constant",
                };
                return Err(fault(what).expected(expected).into());
            };
            let mut leaves = Vec::new();
            flatten(value, &mut leaves);
            if leaves.len() != place.parts.len() {
                let count = place.parts.len();
                let expected = format!("{count} value{}", if count == 1 { "" } else { "s" });
                return Err(fault("too few or too many values").found(leaves.len()).expected(expected).into());
            }
            for (leaf, (id, kind)) in leaves.into_iter().zip(&place.parts) {
                let words = kind.words(leaf);
                let words =
                    words.ok_or_else(|| fault("not a value of this constant").found(leaf).expected(kind.range()))?;
                if values.insert(*id, words).is_some() {
                    return Err(fault("this constant has a value already").found(value).into());
                }
            }
        }
        Ok(values)
    }
}

/// The values in lists in lists, in their order.
fn flatten<'a>(value: &'a Value, leaves: &mut Vec<&'a Value>) {
    match value {
        Value::Array(values) => values.iter().for_each(|value| flatten(value, leaves)),
        leaf => leaves.push(leaf),
    }
}

impl Kind {
    /// A value as SPIR-V has it, if it is one.
    fn words(self, value: &Value) -> Option<Vec<u32>> {
        let wide = |bits: u64| vec![bits as u32, (bits >> 32) as u32];
        let float = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        match self {
            Self::Bool => value.as_bool().map(|truth| vec![truth.into()]),
            Self::Int { bits, signed } => {
                let whole = value.as_integer().filter(|whole| within(bits, signed).contains(&i128::from(*whole)))?;
                Some(if bits > 32 { wide(whole as u64) } else { vec![whole as u32] })
            }
            Self::Float { bits: 64 } => float.filter(|float| float.is_finite()).map(|float| wide(float.to_bits())),
            Self::Float { bits: 32 } => {
                float.map(|float| float as f32).filter(|float| float.is_finite()).map(|float| vec![float.to_bits()])
            }
            Self::Float { .. } => None,
        }
    }

    /// What values it takes.
    fn range(self) -> String {
        match self {
            Self::Bool => "true or false".into(),
            Self::Int { bits, signed } => {
                let range = within(bits, signed);
                format!("a whole number from {} to {}", range.start(), range.end())
            }
            Self::Float { bits: 32 } => "a number up to 3.4e38".into(),
            Self::Float { bits: 64 } => "a number".into(),
            Self::Float { bits } => format!("no value: a constant of {bits} bits has its default"),
        }
    }
}

/// The integers of this many bits, as far as TOML has them.
fn within(bits: u32, signed: bool) -> std::ops::RangeInclusive<i128> {
    let half = 1i128 << bits.saturating_sub(1).min(63);
    if signed { -half..=half - 1 } else { 0..=(2 * half - 1).min(i64::MAX.into()) }
}

/// The specialization constants of a module, by their ids.
fn scalars(words: &[u32]) -> BTreeMap<u32, Scalar> {
    let (mut names, mut kinds, mut ids) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    let mut found = BTreeMap::new();
    for Instruction { op, operands, .. } in instructions(words) {
        match (op, operands) {
            (Some(Op::Name), [id, name @ ..]) => drop(names.insert(*id, text(name))),
            (Some(Op::Decorate), [id, what, number]) if *what == Decoration::SpecId as u32 => {
                ids.insert(*id, *number);
            }
            (Some(Op::TypeBool), [id]) => drop(kinds.insert(*id, Kind::Bool)),
            (Some(Op::TypeInt), [id, bits, sign]) => {
                kinds.insert(*id, Kind::Int { bits: *bits, signed: *sign != 0 });
            }
            (Some(Op::TypeFloat), [id, bits, ..]) => drop(kinds.insert(*id, Kind::Float { bits: *bits })),
            (Some(Op::SpecConstant | Op::SpecConstantTrue | Op::SpecConstantFalse), [ty, id, ..]) => {
                if let (Some(number), Some(kind)) = (ids.get(id), kinds.get(ty)) {
                    let name = names.get(id).cloned().unwrap_or_else(|| number.to_string());
                    found.insert(*number, Scalar { name, kind: *kind });
                }
            }
            _ => {}
        }
    }
    found
}

/// The members of the push constants: name and first byte.
fn members(words: &[u32]) -> Vec<(String, u32)> {
    let (mut names, mut offsets, mut block) = (BTreeMap::new(), BTreeMap::new(), None);
    for Instruction { op, operands, .. } in instructions(words) {
        match (op, operands) {
            (Some(Op::MemberName), [id, member, name @ ..]) => drop(names.insert((*id, *member), text(name))),
            (Some(Op::MemberDecorate), [id, member, what, offset]) if *what == Decoration::Offset as u32 => {
                offsets.insert((*id, *member), *offset);
            }
            (Some(Op::TypePointer), [_, class, of]) if *class == StorageClass::PushConstant as u32 => {
                // Pointers to members come, too.
                block = block.or(offsets.contains_key(&(*of, 0)).then_some(*of));
            }
            _ => {}
        }
    }
    let of_block = offsets.into_iter().filter(|((id, _), _)| Some(*id) == block);
    of_block.map(|(key, offset)| (names.get(&key).cloned().unwrap_or_default(), offset)).collect()
}

/// The text of a name.
fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
}

/// The module with plain constants in place of these specialization constants, of these values or else the defaults.
fn frozen(words: &[u32], own: &BTreeSet<u32>, values: &BTreeMap<u32, Vec<u32>>) -> Vec<u32> {
    let mut ids = BTreeMap::new();
    let mut out = words.get(..HEADER_WORDS).unwrap_or(words).to_vec();
    for Instruction { op, operands, words, .. } in instructions(words) {
        match (op, operands) {
            (Some(Op::Decorate), [id, what, number]) if *what == Decoration::SpecId as u32 && own.contains(number) => {
                ids.insert(*id, *number);
            }
            (Some(Op::SpecConstant), [ty, id, default @ ..]) if ids.contains_key(id) => {
                let value = values.get(&ids[id]).map_or(default, Vec::as_slice);
                append(&mut out, Op::Constant, &[&[*ty, *id], value].concat());
            }
            (Some(truth @ (Op::SpecConstantTrue | Op::SpecConstantFalse)), [ty, id]) if ids.contains_key(id) => {
                let value = values.get(&ids[id]).map_or(truth == Op::SpecConstantTrue, |value| value != &[0]);
                append(&mut out, if value { Op::ConstantTrue } else { Op::ConstantFalse }, &[*ty, *id]);
            }
            _ => out.extend(words),
        }
    }
    out
}
