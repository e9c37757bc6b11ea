//! A number in an instrument file: bare (`mass_g = 140`) or cited (`mass_g = { value = 140, source = ..., ... }`).

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, Range};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{F64Deserializer, MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, IntoDeserializer, MapAccess, SeqAccess, Visitor};

use super::from_toml::NUMBER;
use super::provenance::Certainty;

/// A value with its place in the file's text. The schema shows the value only.
#[derive(Debug, Clone)]
pub struct At<T>(toml::Spanned<T>);

impl<T> At<T> {
    /// Byte range of the value in the text.
    pub fn span(&self) -> Range<usize> {
        self.0.span()
    }
}

impl<T> Deref for At<T> {
    type Target = T;
    fn deref(&self) -> &T {
        self.0.get_ref()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for At<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        toml::Spanned::deserialize(deserializer).map(At)
    }
}

impl<T: JsonSchema> JsonSchema for At<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }
    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// A key of the piano in a file, by its number or its note: 40 or "C4".
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyName(pub String);

impl<'de> Deserialize<'de> for KeyName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct KeyVisitor;
        impl Visitor<'_> for KeyVisitor {
            type Value = KeyName;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number from 1 to 88 or a note in quotes")
            }
            fn visit_i64<E: Error>(self, key: i64) -> Result<KeyName, E> {
                Ok(KeyName(key.to_string()))
            }
            fn visit_str<E: Error>(self, key: &str) -> Result<KeyName, E> {
                Ok(KeyName(key.to_owned()))
            }
        }
        deserializer.deserialize_any(KeyVisitor)
    }
}

impl JsonSchema for KeyName {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "KeyName".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["integer", "string"], "minimum": 1, "maximum": 88 })
    }
}

/// Pattern of a number in quotes, which has a unit: a letter other than that of an exponent, or a sign.
const TYPED_PATTERN: &str = "[A-DF-Za-df-z\u{b5}\u{3bc}\u{b0}%\"'\u{2033}\u{201d}]";

/// Values that can be bare or cited: a number of some range, or a pair of numbers.
pub trait NumberKind: for<'de> Deserialize<'de> + JsonSchema + Clone + fmt::Debug {
    /// Expected value, as an error message describes it.
    const EXPECTED: &'static str;
    /// Its numbers: one, or the two of a pair.
    fn numbers(&self) -> &[f64];
}

macro_rules! scalar_kind {
    ($(#[$doc:meta])* $name:ident, $schema_name:literal, $expected:literal, $schema:tt) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, serde::Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub f64);

        impl NumberKind for $name {
            const EXPECTED: &'static str = $expected;
            fn numbers(&self) -> &[f64] {
                std::slice::from_ref(&self.0)
            }
        }

        impl JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> Cow<'static, str> {
                $schema_name.into()
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    };
}

scalar_kind!(
    /// Any finite number.
    Real, "Real", "a number", { "type": ["number", "string"], "pattern": TYPED_PATTERN });
scalar_kind!(
    /// A number greater than zero.
    Positive, "Positive", "a number greater than 0",
    { "type": ["number", "string"], "pattern": TYPED_PATTERN, "exclusiveMinimum": 0 });
scalar_kind!(
    /// A number of at least zero.
    NonNegative, "NonNegative", "a number that is not negative",
    { "type": ["number", "string"], "pattern": TYPED_PATTERN, "minimum": 0 });
scalar_kind!(
    /// A fraction from 0 to 0.99, the most that the reader takes.
    Part, "Part", "a number from 0 to 0.99", { "type": "number", "minimum": 0, "maximum": 0.99 });
scalar_kind!(
    /// Exponent of a felt's force law, from 1 to 6.
    Exponent, "Exponent", "a number from 1 to 6", { "type": "number", "minimum": 1, "maximum": 6 });

/// A point or direction, `[x, y]`.
#[derive(Debug, Clone, Copy)]
pub struct Pair(pub [f64; 2]);

impl NumberKind for Pair {
    const EXPECTED: &'static str = "two numbers [x, y]";
    fn numbers(&self) -> &[f64] {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Pair {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PairVisitor;
        impl<'de> Visitor<'de> for PairVisitor {
            type Value = Pair;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(Pair::EXPECTED)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Pair, A::Error> {
                let mut pair = [0.0; 2];
                for (index, number) in pair.iter_mut().enumerate() {
                    *number = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(index, &self))?;
                }
                let mut length = 2;
                while seq.next_element::<IgnoredAny>()?.is_some() {
                    length += 1;
                }
                if length == 2 { Ok(Pair(pair)) } else { Err(A::Error::invalid_length(length, &self)) }
            }
        }
        deserializer.deserialize_seq(PairVisitor)
    }
}

impl JsonSchema for Pair {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "Pair".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let item = json_schema!({ "type": ["number", "string"], "pattern": TYPED_PATTERN });
        json_schema!({ "type": "array", "items": item, "minItems": 2, "maxItems": 2 })
    }
}

/// A number with its provenance.
#[derive(Debug, Clone, serde::Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(bound = "T: JsonSchema")]
pub struct Cited<T> {
    /// The number or vector, in the unit at the end of the key's name.
    pub value: At<T>,
    /// Source: a name in `[sources]`.
    pub source: At<String>,
    /// Certainty of the value.
    pub certainty: Certainty,
    /// Deviation in either direction, in the unit of the value (for a vector, of each component). Nine plausible pianos
    /// in ten lie within it. Give either this or `spread_factor`.
    pub spread: Option<At<NonNegative>>,
    /// Deviation as a factor, at least 1, by which the value is multiplied or divided. Use it in place of `spread` for
    /// a value known only to a factor, such as a felt's stiffness.
    pub spread_factor: Option<At<SpreadFactor>>,
    /// Name of a shared deviation. Numbers with the same name deviate together, by the same share of their spreads,
    /// e.g. because they describe one cloth. Requires a spread.
    pub together: Option<At<String>>,
    /// Derivation, or a caution.
    pub note: Option<String>,
}

scalar_kind!(
    /// A factor of uncertainty, at least 1.
    SpreadFactor, "SpreadFactor", "a factor of at least 1", { "type": "number", "minimum": 1 });

/// A number, bare or cited.
#[derive(Debug, Clone)]
pub enum FileQuantity<T> {
    Bare(T),
    Cited(Box<Cited<T>>),
}

/// A number of the file: bare or cited, with its place in the text.
pub type Num<T> = At<FileQuantity<T>>;

impl<T> At<FileQuantity<T>> {
    /// The number itself.
    pub(crate) fn kind(&self) -> &T {
        match &**self {
            FileQuantity::Bare(value) => value,
            FileQuantity::Cited(cited) => &cited.value,
        }
    }

    /// Place of the number itself, without its citation.
    pub fn value_span(&self) -> Range<usize> {
        match &**self {
            FileQuantity::Bare(_) => self.span(),
            FileQuantity::Cited(cited) => cited.value.span(),
        }
    }
}

impl<'de, T: NumberKind> Deserialize<'de> for FileQuantity<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct QuantityVisitor<T>(PhantomData<T>);
        impl<'de, T: NumberKind> Visitor<'de> for QuantityVisitor<T> {
            type Value = FileQuantity<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let cited = "{ value = ..., source = ..., certainty = ... }";
                write!(f, "{}, or one in quotes with its unit, or a cited one {cited}", T::EXPECTED)
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
                let number: F64Deserializer<E> = value.into_deserializer();
                T::deserialize(number).map(FileQuantity::Bare)
            }
            // TOML integers have 64 bits. Those beyond 2^53 lose digits here, but no plausible length or mass is that
            // large.
            fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
                self.visit_f64(value as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
                T::deserialize(SeqAccessDeserializer::new(seq)).map(FileQuantity::Bare)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Cited::deserialize(MapAccessDeserializer::new(map)).map(|cited| FileQuantity::Cited(Box::new(cited)))
            }
        }
        deserializer.deserialize_newtype_struct(NUMBER, QuantityVisitor(PhantomData))
    }
}

impl<T: NumberKind> JsonSchema for FileQuantity<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}Quantity", T::schema_name()).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let bare = T::json_schema(generator);
        let cited = generator.subschema_for::<Cited<T>>();
        json_schema!({
            "description": format!("A quantity, bare or with its provenance: {}.", T::EXPECTED),
            "anyOf": [bare, cited],
        })
    }
}
