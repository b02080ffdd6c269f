//! A module that is to replace a kernel, made to fit what the program gives that kernel: specialization constants of
//! its own, and push constants beyond those that the program sets, become plain constants.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use spirq::spirv::{Decoration, Op};
use spirq::ty::ScalarType;
use toml::Value;

use crate::error::{Input, Result};
use crate::gpu::pushed::{BAKED_ID, as_specialization};
use crate::gpu::reflect::{Reflected, SpecConstant, reflect};
use crate::gpu::spirv_module::{Declared, edited};

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

/// What a file may set: its name, its id if it has one, and the specialization constants that it consists of.
struct Place {
    name: String,
    id: Option<u32>,
    parts: Vec<(u32, ScalarType)>,
}

/// The module with plain constants in place of those that the program does not set: they have the given values, or
/// their defaults; 0 for push constants. `fault` makes an error of what a module does that it must not.
pub(super) fn adapted(
    kernel: &str,
    words: Vec<u32>,
    [new, built_in]: [&Reflected; 2],
    given: &Given,
    fault: &dyn Fn(String) -> Input,
) -> Result<Vec<u32>> {
    let is_extra = |id: &u32| !built_in.constants.contains_key(id);
    let last = new.constants.iter().rfind(|(id, _)| is_extra(id));
    if let Some((id, constant)) = last.filter(|(id, _)| **id >= BAKED_ID) {
        let found = format!("has the specialization constant {} with the id {id}", constant.name);
        return Err(fault(found).expected(format!("ids below {BAKED_ID}")).into());
    }
    let pushed = built_in.push_bytes;
    let words = if new.push_bytes > pushed {
        let some = Some(&words).filter(|_| new.push_bytes <= MOST_PUSHED);
        some.and_then(|words| as_specialization(words, pushed)).ok_or_else(|| {
            let found = format!("takes {} bytes of push constants, and the program sets {pushed}", new.push_bytes);
            let most = format!("at most {MOST_PUSHED} bytes");
            fault(found).expected(format!("members of 32-bit numbers beyond those, with constants for indices; {most}"))
        })?
    } else {
        words
    };
    let mut constants = reflect(kernel, &words)?.constants.clone();
    constants.retain(|id, _| is_extra(id));
    let part = |(id, constant): (&u32, &SpecConstant)| (*id, constant.ty.clone());
    let mut places: Vec<Place> = Vec::new();
    for (id, constant) in constants.range(..BAKED_ID) {
        places.push(Place { name: constant.name.clone(), id: Some(*id), parts: vec![part((id, constant))] });
    }
    for (at, (name, offset)) in new.pushed.iter().enumerate().filter(|(_, (_, offset))| *offset >= pushed) {
        let first = |offset: u32| BAKED_ID + offset / 4;
        let end = new.pushed.get(at + 1).map_or(u32::MAX, |(_, next)| first(*next));
        let parts = constants.range(first(*offset)..end).map(part).collect();
        places.push(Place { name: name.clone(), id: None, parts });
    }
    let set_members = new.pushed.iter().filter(|(_, offset)| *offset < pushed).map(|(name, _)| name);
    let set: Vec<&String> = built_in.set_by_program().map(|(_, constant)| &constant.name).chain(set_members).collect();
    let values = given.of(&places, &set)?;
    Ok(frozen(&words, &constants.into_keys().collect(), &values))
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
            for (leaf, (id, ty)) in leaves.into_iter().zip(&place.parts) {
                let words = constant_words(ty, leaf);
                let words =
                    words.ok_or_else(|| fault("not a value of this constant").found(leaf).expected(range(ty)))?;
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

/// A value of this type as SPIR-V has it, if it is one.
fn constant_words(ty: &ScalarType, value: &Value) -> Option<Vec<u32>> {
    let wide = |bits: u64| vec![bits as u32, (bits >> 32) as u32];
    let float = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match *ty {
        ScalarType::Boolean => value.as_bool().map(|truth| vec![truth.into()]),
        ScalarType::Integer { bits, is_signed } => {
            let whole = value.as_integer().filter(|whole| within(bits, is_signed).contains(&i128::from(*whole)))?;
            Some(if bits > 32 { wide(whole as u64) } else { vec![whole as u32] })
        }
        ScalarType::Float { bits: 64 } => float.filter(|float| float.is_finite()).map(|float| wide(float.to_bits())),
        ScalarType::Float { bits: 32 } => {
            float.map(|float| float as f32).filter(|float| float.is_finite()).map(|float| vec![float.to_bits()])
        }
        _ => None,
    }
}

/// What values a constant of this type takes.
fn range(ty: &ScalarType) -> String {
    match *ty {
        ScalarType::Boolean => "true or false".into(),
        ScalarType::Integer { bits, is_signed } => {
            let range = within(bits, is_signed);
            format!("a whole number from {} to {}", range.start(), range.end())
        }
        ScalarType::Float { bits: 32 } => "a number up to 3.4e38".into(),
        ScalarType::Float { bits: 64 } => "a number".into(),
        ScalarType::Float { bits } => format!("no value: a constant of {bits} bits has its default"),
        ScalarType::Void => "no value".into(),
    }
}

/// The integers of this many bits, as far as TOML has them.
fn within(bits: u32, signed: bool) -> std::ops::RangeInclusive<i128> {
    let half = 1i128 << bits.saturating_sub(1).min(63);
    if signed { -half..=half - 1 } else { 0..=(2 * half - 1).min(i64::MAX.into()) }
}

/// The module with plain constants in place of these specialization constants, of these values or else the defaults.
fn frozen(words: &[u32], spec_ids: &BTreeSet<u32>, values: &BTreeMap<u32, Vec<u32>>) -> Vec<u32> {
    let declared = Declared::of(words);
    let number = |id: u32| declared.decoration(id, Decoration::SpecId).filter(|number| spec_ids.contains(number));
    edited(words, |out, instruction| match (instruction.op, instruction.operands) {
        (Some(Op::Decorate), [_, what, number]) if *what == Decoration::SpecId as u32 && spec_ids.contains(number) => {}
        (Some(Op::SpecConstant), [ty, id, default @ ..]) if number(*id).is_some() => {
            let value = number(*id).and_then(|number| values.get(&number)).map_or(default, Vec::as_slice);
            out.put(Op::Constant, &[&[*ty, *id], value].concat());
        }
        (Some(truth @ (Op::SpecConstantTrue | Op::SpecConstantFalse)), [ty, id]) if number(*id).is_some() => {
            let value = number(*id).and_then(|number| values.get(&number));
            let value = value.map_or(truth == Op::SpecConstantTrue, |value| value != &[0]);
            out.put(if value { Op::ConstantTrue } else { Op::ConstantFalse }, &[*ty, *id]);
        }
        _ => out.keep(instruction),
    })
}
