//! Three numbers in a scene file: coordinates, or colour channels that may be given as one number.

use serde::de::{Deserialize, Deserializer, Error as _, SeqAccess, Visitor};

/// Three coordinates: `[x, y, z]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vector(pub [f64; 3]);

/// Three channels: `[r, g, b]`, or one number for all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rgb(pub [f64; 3]);

/// What is shown where no object is: a colour, or the word `environment` or `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Background {
    /// Three channels.
    Color([f64; 3]),
    /// The environment.
    Environment,
    /// Nothing: the picture is transparent.
    None,
}

impl Default for Background {
    fn default() -> Self {
        Self::Color([0.0; 3])
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(ColorOrWord)
    }
}

/// Reads a colour or a word.
struct ColorOrWord;

impl<'de> Visitor<'de> for ColorOrWord {
    type Value = Background;

    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str("a number, [r, g, b], \"environment\" or \"none\"")
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Background, E> {
        Ok(Background::Color([value; 3]))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Background, E> {
        Three { one_for_all: true }.visit_i64(value).map(Background::Color)
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Background, E> {
        match value {
            "environment" => Ok(Background::Environment),
            "none" => Ok(Background::None),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(value), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, from: A) -> Result<Background, A::Error> {
        Three { one_for_all: true }.visit_seq(from).map(Background::Color)
    }
}

/// A factor on radiance, or the word `auto`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Exposure {
    /// The factor.
    Factor(f64),
    /// Metered from the picture.
    Auto,
}

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(FactorOrWord)
    }
}

/// Reads a factor or the word.
struct FactorOrWord;

impl Visitor<'_> for FactorOrWord {
    type Value = Exposure;

    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str("a number or \"auto\"")
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Exposure, E> {
        Ok(Exposure::Factor(value))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Exposure, E> {
        #[allow(clippy::cast_precision_loss)] // only beyond 2^53, where a factor is as good as its neighbour
        self.visit_f64(value as f64)
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Exposure, E> {
        match value {
            "auto" => Ok(Exposure::Auto),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(value), &self)),
        }
    }
}

impl<'de> Deserialize<'de> for Vector {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_seq(Three { one_for_all: false }).map(Self)
    }
}

impl<'de> Deserialize<'de> for Rgb {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(Three { one_for_all: true }).map(Self)
    }
}

/// Reads exactly three numbers, or one for all three where that is allowed.
struct Three {
    one_for_all: bool,
}

impl<'de> Visitor<'de> for Three {
    type Value = [f64; 3];

    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(if self.one_for_all { "a number or [r, g, b]" } else { "[x, y, z]" })
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<[f64; 3], E> {
        if self.one_for_all {
            return Ok([value; 3]);
        }
        Err(E::invalid_type(serde::de::Unexpected::Float(value), &self))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<[f64; 3], E> {
        if !self.one_for_all {
            return Err(E::invalid_type(serde::de::Unexpected::Signed(value), &self));
        }
        #[allow(clippy::cast_precision_loss)] // only beyond 2^53, which is out of every range
        self.visit_f64(value as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<[f64; 3], A::Error> {
        let mut values = Vec::with_capacity(3);
        while let Some(value) = from.next_element()? {
            values.push(value);
        }
        let count = values.len();
        values.try_into().map_err(|_| A::Error::invalid_length(count, &self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    struct Row {
        at: Option<Vector>,
        colour: Option<Rgb>,
    }

    #[test]
    fn reads_whole_and_broken_numbers() {
        let row: Row = toml::from_str("at = [1, 2.5, -3]\ncolour = 2").expect("both");
        assert_eq!(row.at, Some(Vector([1.0, 2.5, -3.0])));
        assert_eq!(row.colour, Some(Rgb([2.0; 3])));
        let row: Row = toml::from_str("colour = [1, 0, 0.5]").expect("a list");
        assert_eq!(row.colour, Some(Rgb([1.0, 0.0, 0.5])));
    }

    #[test]
    fn refuses_anything_but_three() {
        let cases = [
            ("at = 1", "invalid type: integer `1`, expected [x, y, z]"),
            ("at = [1, 2]", "invalid length 2, expected [x, y, z]"),
            ("at = [1, 2, 3, 4]", "invalid length 4, expected [x, y, z]"),
            ("colour = 'red'", "invalid type: string \"red\", expected a number or [r, g, b]"),
            ("colour = [1, 'x', 2]", "invalid type: string \"x\", expected f64"),
        ];
        for (text, message) in cases {
            let error = toml::from_str::<Row>(text).map_err(|e| e.message().to_owned());
            assert_eq!(error.err().as_deref(), Some(message));
        }
    }
}
