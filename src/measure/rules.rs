//! How far each word of a buffer may be from the reference.

use crate::layout::{BufferId, Number, Word};
use crate::state::{Field, Rounding, State, Tolerance};

/// The field that a word belongs to, by the word's path: `center` of `center.1`.
#[must_use]
pub fn field_of(path: &str) -> &str {
    path.trim_end_matches(|c: char| c == '.' || c.is_ascii_digit())
}

/// What a tolerance means for each word of a buffer of the reference.
pub struct Rules<'a> {
    layout: Vec<Word>,
    words: &'a [u32],
    /// The rule of each word of an element; none if the word must agree bit for bit.
    rules: Vec<Option<Rule>>,
    /// What rounding explains, element by element, for these fields.
    rounding: Option<(&'static Rounding, Vec<f64>)>,
}

/// Tolerance of one float: a share of its value, plus a floor, which may be relative to another word of the element.
struct Rule {
    relative: f64,
    floor: f64,
    of: Option<usize>,
}

/// How far one word may be off.
#[derive(Clone, Copy, Debug, Default)]
pub struct Allowed {
    /// The floor of its tolerance.
    pub lowest: f64,
    /// What rounding of its element's own data explains.
    pub rounding: f64,
    /// The largest difference that is allowed; none if the bits must agree.
    pub most: Option<f64>,
}

impl Allowed {
    /// What allows the most, in words; none if that is the share of the value itself.
    #[must_use]
    pub fn beside_its_share(&self) -> Option<String> {
        let most = self.most?;
        let text = |part: f64, what: &str| Some(format!("allowed {most:.1e}, {part:.1e} of it {what}"));
        match (self.lowest, self.rounding) {
            (lowest, rounding) if lowest + rounding < 0.5 * most => None,
            (lowest, rounding) if rounding > lowest => text(rounding, "by the rounding of its own element"),
            (lowest, _) => text(lowest, "by the floor"),
        }
    }
}

impl<'a> Rules<'a> {
    /// The rules for a buffer of this state.
    #[must_use]
    pub fn new(slot: BufferId, reference: &'a State, tolerance: Tolerance) -> Self {
        let words: &[u32] = bytemuck::cast_slice(reference.data.bytes(slot));
        let layout = (slot.spec().words)();
        let rules = rules(&layout, words, tolerance);
        let rounding = match tolerance {
            Tolerance::Rounded(_, rounding) => Some((rounding, (rounding.of)(reference))),
            _ => None,
        };
        Self { layout, words, rules, rounding }
    }

    /// What is allowed of the word of this index in the buffer.
    #[must_use]
    pub fn at(&self, index: usize) -> Allowed {
        let k = index % self.layout.len();
        let word = &self.layout[k];
        let (Some(rule), Number::Float) = (&self.rules[k], word.number) else { return Allowed::default() };
        let value = |at: usize| f64::from(f32::from_bits(self.words[at]));
        let lowest = rule.floor * rule.of.map_or(1.0, |of| value(index - k + of));
        let more = self.rounding.as_ref().and_then(|(rounding, more)| {
            let field = rounding.fields.iter().position(|name| *name == field_of(&word.path))?;
            more.get(index / self.layout.len() * rounding.fields.len() + field)
        });
        let rounding = more.copied().unwrap_or(0.0);
        let most = rule.relative * value(index).abs() + lowest + rounding;
        Allowed { lowest, rounding, most: Some(most) }
    }
}

/// The rule for each word of an element; `None` where it must agree bit for bit.
fn rules(layout: &[Word], reference: &[u32], tolerance: Tolerance) -> Vec<Option<Rule>> {
    let words = 0..layout.len();
    let group = |k: usize| field_of(&layout[k].path);
    match tolerance {
        Tolerance::Exact => words.map(|_| None).collect(),
        Tolerance::Float { relative, floor } => {
            // Largest magnitude of each field, over all components of a vector.
            let groups: Vec<usize> =
                words.clone().map(|k| (0..k).find(|&j| group(j) == group(k)).unwrap_or(k)).collect();
            let mut largest = vec![0f64; layout.len()];
            for (i, &word) in reference.iter().enumerate() {
                let value = f64::from(f32::from_bits(word)).abs();
                if value.is_finite() {
                    let k = groups[i % layout.len()];
                    largest[k] = largest[k].max(value);
                }
            }
            let rule = |k: usize| Rule {
                relative: f64::from(relative),
                floor: f64::from(floor) * largest[groups[k]],
                of: None,
            };
            words.map(|k| Some(rule(k))).collect()
        }
        Tolerance::Fields(fields) | Tolerance::Rounded(fields, _) => {
            let index = |name: &str| words.clone().find(|&j| !name.is_empty() && group(j) == name);
            let field = |k: usize| fields.iter().find(|field| field.name == group(k) || field.name == layout[k].path);
            let rule = |field: &Field| Rule {
                relative: f64::from(field.relative),
                floor: f64::from(field.floor),
                of: index(field.of),
            };
            words.clone().map(|k| field(k).map(rule)).collect()
        }
    }
}
