//! The elements of an ascii file, one a line.
//!
//! Read by hand: the crate ply-rs-bw knows no `.5` or `5.`, and refuses a file for properties that are ignored, such as
//! normals that are not numbers.

use crate::error::Input;
use crate::scene::range::Checked;
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType};
use std::str::FromStr;

/// Maximum number of characters of a line that a message shows.
const SHOWN: usize = 60;

/// Lines that are not blank, with their numbers.
pub(super) struct Lines<'a>(Box<dyn Iterator<Item = (usize, &'a str)> + 'a>);

impl<'a> Lines<'a> {
    /// The lines of a text that `before` others precede.
    pub fn of(text: &'a str, before: usize) -> Self {
        let lines = text.lines().enumerate().map(move |(number, line)| (before + number + 1, line.trim()));
        Self(Box::new(lines.filter(|(_, line)| !line.is_empty())))
    }

    /// The next elements of a kind.
    pub fn elements<E: PropertyAccess>(&mut self, kind: &ElementDef) -> Checked<Vec<E>> {
        let mut all = Vec::new();
        for _ in 0..kind.count {
            if kind.properties.is_empty() {
                all.push(E::new());
                continue;
            }
            let what = "the mesh file is not PLY as it should be: ";
            let Some((number, line)) = self.0.next() else {
                let fault = Input::new(format!("{what}it ends among its elements `{}`", kind.name));
                return Err(fault.found(all.len()).expected(kind.count));
            };
            all.push(element(line, kind).ok_or_else(|| {
                let fault = Input::new(format!("{what}not an element `{}`", kind.name)).line(number);
                let names: Vec<_> = kind.properties.keys().map(String::as_str).collect();
                fault.found(line.chars().take(SHOWN).collect::<String>()).expected(names.join(", "))
            })?);
        }
        Ok(all)
    }
}

/// The element of a line; none if it has too few numbers, too many, or none where one is asked for.
fn element<E: PropertyAccess>(line: &str, kind: &ElementDef) -> Option<E> {
    let (mut words, mut made) = (line.split_ascii_whitespace(), E::new());
    for (name, property) in &kind.properties {
        let value = match &property.data_type {
            PropertyType::Scalar(kind) => scalar(kind, words.next()?),
            PropertyType::List(_, kind) => {
                let count = whole::<usize>(words.next()?)?;
                let entries: Vec<&str> = words.by_ref().take(count).collect();
                if entries.len() < count {
                    return None;
                }
                list(kind, &entries)
            }
        };
        // The value of a property that is ignored need not be a number.
        let Some(value) = value else {
            match E::new().set_property(name, Property::Double(0.0)) {
                PropertyAccessResult::Ignored => continue,
                _ => return None,
            }
        };
        if made.set_property(name, value) == PropertyAccessResult::UnsupportedType {
            return None;
        }
    }
    words.next().is_none().then_some(made)
}

/// A number, as `strtod` takes it but for hexadecimal ones.
fn number<T: FromStr + PartialEq>(word: &str) -> Option<T> {
    // NaN is not equal to itself.
    #[allow(clippy::eq_op)]
    word.parse().ok().filter(|x| x == x)
}

/// A whole number, which may be written with a fraction or an exponent.
fn whole<T: FromStr + PartialEq + TryFrom<i64>>(word: &str) -> Option<T> {
    let written = || number::<f64>(word).filter(|x| x.fract() == 0.0 && x.abs() < 1e15);
    number(word).or_else(|| T::try_from(written()? as i64).ok())
}

fn scalar(kind: &ScalarType, word: &str) -> Option<Property> {
    Some(match kind {
        ScalarType::Char => Property::Char(whole(word)?),
        ScalarType::UChar => Property::UChar(whole(word)?),
        ScalarType::Short => Property::Short(whole(word)?),
        ScalarType::UShort => Property::UShort(whole(word)?),
        ScalarType::Int => Property::Int(whole(word)?),
        ScalarType::UInt => Property::UInt(whole(word)?),
        ScalarType::Float => Property::Float(number(word)?),
        ScalarType::Double => Property::Double(number(word)?),
    })
}

fn list(kind: &ScalarType, words: &[&str]) -> Option<Property> {
    fn all<T>(words: &[&str], parse: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
        words.iter().map(|word| parse(word)).collect()
    }
    Some(match kind {
        ScalarType::Char => Property::ListChar(all(words, whole)?),
        ScalarType::UChar => Property::ListUChar(all(words, whole)?),
        ScalarType::Short => Property::ListShort(all(words, whole)?),
        ScalarType::UShort => Property::ListUShort(all(words, whole)?),
        ScalarType::Int => Property::ListInt(all(words, whole)?),
        ScalarType::UInt => Property::ListUInt(all(words, whole)?),
        ScalarType::Float => Property::ListFloat(all(words, number)?),
        ScalarType::Double => Property::ListDouble(all(words, number)?),
    })
}
