//! The felt of a zone in a file: a spring and the parameters of one loss law. Keys, units, ranges and descriptions of
//! these parameters come from the engine's tables ([`moreau::LAWS`]), so reader, schema and messages name no law.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range as Span;
use std::sync::LazyLock;

use moreau::{LAW_NUMBERS, LAWS, LawNumber, Loss, Range};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use super::Felt;
use super::error::Fault;
use super::file_number::FileNumber;
use super::quantity::{Exponent, NonNegative, Num, Part, Positive};
use super::reader::{MM_PER_M, Reader};

const STIFFNESS: &str = FileNumber::FELT_STIFFNESS.key;
const EXPONENT: &str = FileNumber::FELT_EXPONENT.key;
const THICKNESS: &str = FileNumber::FELT_THICKNESS.key;

/// Parameters of all laws. A key that several laws share is listed once.
static NUMBERS: LazyLock<Vec<&'static LawNumber>> = LazyLock::new(|| {
    let mut numbers: Vec<&LawNumber> = Vec::new();
    for number in LAWS.iter().copied().flatten() {
        if numbers.iter().all(|known| known.key != number.key) {
            numbers.push(number);
        }
    }
    numbers
});

static FIELDS: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let spring = [STIFFNESS, EXPONENT, THICKNESS];
    NUMBERS.iter().map(|number| number.key).chain(spring).collect()
});

/// Felt law for the compression g in metres: k g^r, and a loss.
#[derive(Debug)]
pub(crate) struct FeltToml {
    stiffness: Num<NonNegative>,
    exponent: Num<Exponent>,
    thickness_mm: Option<Num<Positive>>,
    /// Parameters of the loss law, in the order of the file.
    loss: Vec<(&'static LawNumber, LossNum)>,
}

/// A parameter of a law, of the kind that its range requires.
#[derive(Debug)]
enum LossNum {
    NonNegative(Num<NonNegative>),
    Positive(Num<Positive>),
    Part(Num<Part>),
}

impl LossNum {
    fn read<'de, M: MapAccess<'de>>(range: Range, map: &mut M) -> Result<Self, M::Error> {
        Ok(match range {
            Range::Part | Range::InnerPart => LossNum::Part(map.next_value()?),
            Range::Between(..) => LossNum::Positive(map.next_value()?),
            _ => LossNum::NonNegative(map.next_value()?),
        })
    }

    fn schema(range: Range, generator: &mut SchemaGenerator) -> Schema {
        match range {
            Range::Part | Range::InnerPart => generator.subschema_for::<Num<Part>>(),
            Range::Between(..) => generator.subschema_for::<Num<Positive>>(),
            _ => generator.subschema_for::<Num<NonNegative>>(),
        }
    }

    fn span(&self) -> Span<usize> {
        match self {
            LossNum::NonNegative(number) => number.value_span(),
            LossNum::Positive(number) => number.value_span(),
            LossNum::Part(number) => number.value_span(),
        }
    }

    /// Checks the range and converts the number to the engine's unit.
    fn value(&self, number: &LawNumber, reader: &mut Reader<'_>) -> Result<f64, Fault> {
        let of = FileNumber::of_law(number);
        let value = match self {
            LossNum::NonNegative(number) => reader.scalar(number, of)?,
            LossNum::Positive(number) => reader.scalar(number, of)?,
            LossNum::Part(number) => reader.scalar(number, of)?,
        };
        Ok(value / number.units_per_si)
    }
}

impl<'de> Deserialize<'de> for FeltToml {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = FeltToml;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("struct FeltToml")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<FeltToml, M::Error> {
                let (mut stiffness, mut exponent, mut thickness_mm, mut loss) = (None, None, None, Vec::new());
                while let Some(key) = map.next_key::<Cow<'_, str>>()? {
                    match &*key {
                        STIFFNESS => stiffness = Some(map.next_value()?),
                        EXPONENT => exponent = Some(map.next_value()?),
                        THICKNESS => thickness_mm = Some(map.next_value()?),
                        key => {
                            let Some(&number) = NUMBERS.iter().find(|number| number.key == key) else {
                                return Err(M::Error::unknown_field(key, &FIELDS));
                            };
                            loss.push((number, LossNum::read(number.range, &mut map)?));
                        }
                    }
                }
                // The keys of a table do not arrive in the order of the file.
                loss.sort_by_key(|(_, number): &(_, LossNum)| number.span().start);
                Ok(FeltToml {
                    stiffness: stiffness.ok_or_else(|| M::Error::missing_field(STIFFNESS))?,
                    exponent: exponent.ok_or_else(|| M::Error::missing_field(EXPONENT))?,
                    thickness_mm,
                    loss,
                })
            }
        }
        deserializer.deserialize_struct("FeltToml", &FIELDS, Table)
    }
}

impl JsonSchema for FeltToml {
    fn schema_name() -> Cow<'static, str> {
        "Felt".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut properties = serde_json::Map::new();
        let mut add = |key: &str, meaning: &str, schema: Schema| {
            properties.insert(key.to_owned(), serde_json::json!({ "description": meaning, "allOf": [schema] }));
        };
        add(STIFFNESS, "Stiffness k of the spring k g^r, N/m^r.", generator.subschema_for::<Num<NonNegative>>());
        add(EXPONENT, "Exponent r of the spring k g^r, from 1 to 6.", generator.subschema_for::<Num<Exponent>>());
        let thickness = "Thickness of felt, cloth or leather, of both sides together, mm. It does not affect the \
                         motion: a run that compresses the felt by more is marked as not trusted. Not checked when \
                         absent.";
        add(THICKNESS, thickness, generator.subschema_for::<Num<Positive>>());
        for number in NUMBERS.iter() {
            add(number.key, number.meaning, LossNum::schema(number.range, generator));
        }
        json_schema!({
            "description": "Force of a felt at the compression g in metres: the spring k g^r and the loss of one law, chosen by its keys. The force never pulls.",
            "type": "object",
            "properties": properties,
            "required": [STIFFNESS, EXPONENT],
            "additionalProperties": false,
        })
    }
}

/// Checks a felt and converts it to SI units.
pub(crate) fn read_felt(table: &FeltToml, reader: &mut Reader<'_>) -> Result<Felt, Fault> {
    let law = law_of(&table.loss)?;
    let mut numbers = [0.0; LAW_NUMBERS];
    for (number, given) in &table.loss {
        let place = LAWS[law].iter().position(|of_law| of_law.key == number.key);
        numbers[place.unwrap_or(0)] = given.value(number, reader)?;
    }
    Ok(Felt {
        stiffness: reader.scalar(&table.stiffness, FileNumber::FELT_STIFFNESS)?,
        exponent: reader.scalar(&table.exponent, FileNumber::FELT_EXPONENT)?,
        loss: Loss::with(law, numbers).unwrap_or_default(),
        thickness_m: match &table.thickness_mm {
            None => None,
            Some(thickness) => Some(reader.scalar(thickness, FileNumber::FELT_THICKNESS)? / MM_PER_M),
        },
    })
}

/// Finds the law that has all the given keys and needs no others; returns its index in [`LAWS`].
fn law_of(given: &[(&'static LawNumber, LossNum)]) -> Result<usize, Fault> {
    let says = |key: &str| given.iter().find(|(number, _)| number.key == key);
    let knows = |law: &[LawNumber], key: &str| law.iter().any(|number| number.key == key);
    let lacks = |law: &'static [LawNumber]| law.iter().find(|number| number.needed && says(number.key).is_none());
    let possible =
        || LAWS.iter().copied().enumerate().filter(|(_, law)| given.iter().all(|(number, _)| knows(law, number.key)));
    if let Some((place, _)) = possible().find(|(_, law)| lacks(law).is_none()) {
        return Ok(place);
    }
    let last = given.iter().max_by_key(|(number, _)| NUMBERS.iter().position(|known| known.key == number.key));
    if let (Some(missing), Some((_, given))) = (possible().find_map(|(_, law)| lacks(law)), last) {
        let expected = format!("`{}` beside it", missing.key);
        return Err(Fault::at(given.span(), "this key needs another one", expected));
    }
    let together = |a: &LawNumber, b: &LawNumber| LAWS.iter().any(|law| knows(law, a.key) && knows(law, b.key));
    for (k, (second, span)) in given.iter().enumerate() {
        if let Some((first, _)) = given[..k].iter().find(|(first, _)| !together(first, second)) {
            let expected = format!("either `{}` or `{}`", first.key, second.key);
            return Err(Fault::at(span.span(), "a felt can have only one law", expected).found("both"));
        }
    }
    let last = last.map_or(0..0, |(_, given)| given.span());
    Err(Fault::at(last, "a felt can have only one law", "the keys of one law").found("keys of several laws"))
}
