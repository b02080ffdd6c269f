//! How far a device may be from the reference: by value, by field, and by what rounding explains.

use super::State;

/// How far a device's value may be from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Bit for bit: decisions, indices, minima and maxima.
    Exact,
    /// A float may differ by `relative` times the reference's magnitude plus `floor` times the largest magnitude of
    /// its field in the buffer; everything that is not a float bit for bit.
    Float {
        /// Share of the value itself.
        relative: f32,
        /// Share of the field's largest value.
        floor: f32,
    },
    /// Each float field by its own rule; everything that is not a float bit for bit.
    Fields(&'static [Field]),
    /// The same, and some fields by what rounding may make of the numbers that this very element comes from.
    Rounded(&'static [Field], &'static Rounding),
}

/// Differences that rounding explains, element by element, where no other field of the element tells their size.
pub struct Rounding {
    /// Where they come from, in a few words.
    pub about: &'static str,
    /// The fields that may differ by as much more.
    pub fields: &'static [&'static str],
    /// The differences, one per field of each element of the buffer, from the reference's state after the stage.
    pub of: fn(&State) -> Vec<f64>,
}

impl std::fmt::Debug for Rounding {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{:?} also by {}", self.fields, self.about)
    }
}

impl PartialEq for Rounding {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

/// The tolerance of one field of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// The field.
    pub name: &'static str,
    /// Share of the value itself.
    pub relative: f32,
    /// Added to that: a share of the field `of` of the same element.
    pub floor: f32,
    /// The field that the floor is a share of; if empty, the floor is absolute.
    pub of: &'static str,
}
