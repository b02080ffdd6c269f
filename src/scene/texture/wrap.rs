//! How textures continue beyond their edges.

use crate::layout::{WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error as _, IntoDeserializer, SeqAccess, Visitor};

/// How a texture continues beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// The outermost texels continue.
    Clamp,
    /// It repeats, every other copy mirrored.
    Mirror,
}

/// How a texture continues beyond its left and right edges, and beyond its lower and upper ones: two words, or one for
/// both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::scene) struct Wraps(pub [Wrap; 2]);

impl<'de> Deserialize<'de> for Wraps {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(OneOrTwo)
    }
}

/// Reads one word or two.
struct OneOrTwo;

impl<'de> Visitor<'de> for OneOrTwo {
    type Value = Wraps;

    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str("\"repeat\", \"clamp\", \"mirror\", or two of them")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Wraps, E> {
        Wrap::deserialize(word.into_deserializer()).map(|wrap| Wraps([wrap; 2]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, from: A) -> Result<Wraps, A::Error> {
        let words = Vec::<Wrap>::deserialize(SeqAccessDeserializer::new(from))?;
        let count = words.len();
        words.try_into().map(Wraps).map_err(|_| A::Error::invalid_length(count, &self))
    }
}

impl Wrap {
    /// The constant that shaders use.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Repeat => WRAP_REPEAT,
            Self::Clamp => WRAP_CLAMP,
            Self::Mirror => WRAP_MIRROR,
        }
    }

    /// The period, in sides of the texture; none for clamp.
    #[must_use]
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Repeat => Some(1.0),
            Self::Clamp => None,
            Self::Mirror => Some(2.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_word_holds_in_both_directions() {
        let read = |text: &str| {
            #[derive(serde::Deserialize)]
            struct Row {
                wrap: Wraps,
            }
            toml::from_str::<Row>(text).map(|row| row.wrap.0).map_err(|error| error.message().to_owned())
        };
        assert_eq!(read("wrap = 'mirror'"), Ok([Wrap::Mirror; 2]));
        assert_eq!(read("wrap = ['repeat', 'clamp']"), Ok([Wrap::Repeat, Wrap::Clamp]));
        let errors = ["wrap = 'tile'", "wrap = ['clamp']", "wrap = ['clamp', 'clamp', 'clamp']", "wrap = 3"].map(read);
        assert!(errors.iter().all(Result::is_err), "{errors:?}");
    }
}
