//! Deserializes TOML into the types of a file.
//!
//! It does what `toml::from_str` does. The deserializer of `toml` consists of four types, so every type of a file, each
//! kind of number included, is compiled a dozen times; this was most of this crate's compile time. Here values, keys
//! and spans share one type (`Node`), also within tables and lists.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::ops::Range;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use serde_spanned::de::is_spanned;
use toml::Spanned;
use toml::de::{DeFloat, DeInteger, DeTable, DeValue};

use crate::units::{NumberError, Quantity};

/// Key under which `serde` receives a date, as from `toml`. A date is neither a number nor a text.
const DATE: &str = "$__toml_private_datetime";

/// Error of a text that is not TOML or does not match the expected type.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct TomlError {
    /// Message of the parser or of `serde`.
    pub message: String,
    /// Byte range of the text, if it is known.
    pub span: Option<Range<usize>>,
    /// Expected text, if the message does not state it.
    pub expected: Option<String>,
}

impl TomlError {
    /// Returns the message with the number of its line in the text.
    #[must_use]
    pub fn in_line(&self, text: &str) -> String {
        format!("line {}: {}", self.line(text), self.message)
    }

    /// Returns the line of the text, from 1; 1 if the place is unknown.
    #[must_use]
    pub fn line(&self, text: &str) -> usize {
        self.span.as_ref().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1)
    }

    /// Sets the place, unless it is known already.
    fn within(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }
}

impl Error for TomlError {
    fn custom<T: Display>(message: T) -> Self {
        TomlError { message: message.to_string(), span: None, expected: None }
    }
}

/// Reads a TOML text into a type.
///
/// # Errors
/// The text is not TOML, or does not match the type.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, TomlError> {
    Document::parse(text)?.read(&Replaced::default())
}

/// A TOML text that is parsed once and read into a type as often as wanted, each time with some values replaced.
pub(crate) struct Document<'a>(Spanned<DeTable<'a>>);

/// A value of a document: its address.
type Place = usize;

fn place(value: &Spanned<DeValue<'_>>) -> Place {
    std::ptr::from_ref(value).addr()
}

/// Numbers that are read in place of those of a document, and tables that are not read.
#[derive(Debug, Clone, Default)]
pub(crate) struct Replaced {
    numbers: BTreeMap<Place, f64>,
    removed: BTreeSet<Place>,
}

impl<'a> Document<'a> {
    /// Parses a text.
    ///
    /// # Errors
    /// The text is not TOML.
    pub(crate) fn parse(text: &'a str) -> Result<Self, TomlError> {
        let table = DeTable::parse(text);
        table.map(Document).map_err(|error| {
            let (message, span) = (error.message().to_owned(), error.span());
            TomlError { message, span, expected: None }
        })
    }

    /// Reads the document into a type.
    ///
    /// # Errors
    /// The document does not match the type.
    pub(crate) fn read<T: DeserializeOwned>(&self, replaced: &Replaced) -> Result<T, TomlError> {
        T::deserialize(Node::Table(self.0.get_ref(), self.0.span(), replaced))
    }

    /// The value at a path; entries of a list are distinguished by their `name`.
    pub(crate) fn find(&self, path: &str) -> Option<&Spanned<DeValue<'a>>> {
        let mut segments = path.split('.');
        let mut value = self.0.get_ref().get(segments.next()?)?;
        for segment in segments {
            let is_it = |entry: &&Spanned<DeValue<'a>>| {
                let name = entry.get_ref().as_table().and_then(|table| table.get("name"));
                name.and_then(|name| name.get_ref().as_str()) == Some(segment)
            };
            value = match value.get_ref() {
                DeValue::Array(entries) => entries.iter().find(is_it)?,
                DeValue::Table(table) => table.get(segment)?,
                _ => return None,
            };
        }
        Some(value)
    }

    /// The numbers of a value, bare or cited.
    fn numbers_of(value: &'a Spanned<DeValue<'a>>) -> Option<Vec<&'a Spanned<DeValue<'a>>>> {
        let value = value.get_ref().as_table().map_or(Some(value), |cited| cited.get("value"))?;
        Some(match value.get_ref() {
            DeValue::Array(numbers) => numbers.iter().collect(),
            _ => vec![value],
        })
    }

    /// A number, or the components of a vector, bare or cited.
    pub(crate) fn numbers(&'a self, path: &str) -> Option<Vec<f64>> {
        let number = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
            DeValue::String(text) => typed_number_at(text, path),
            DeValue::Float(number) => float(number).ok(),
            DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).ok().map(|n| n as f64),
            _ => None,
        };
        Self::numbers_of(self.find(path)?)?.into_iter().map(number).collect()
    }

    /// Replaces the numbers at a path. `None` if it leads to another count of numbers.
    pub(crate) fn replace(&'a self, path: &str, numbers: &[f64], replaced: &mut Replaced) -> Option<()> {
        let places = Self::numbers_of(self.find(path)?)?;
        if places.len() != numbers.len() {
            return None;
        }
        replaced.numbers.extend(places.into_iter().map(place).zip(numbers.iter().copied()));
        Some(())
    }

    /// Removes the value at a path. `None` if there is none.
    pub(crate) fn remove(&self, path: &str, replaced: &mut Replaced) -> Option<()> {
        replaced.removed.insert(place(self.find(path)?));
        Some(())
    }
}

/// Name by which a type asks for a number that may be cited, or typed as text with its unit.
pub(crate) const NUMBER: &str = "$erard_number";

/// Reads a number that is typed as text with its unit, in the unit at the end of the first of these keys that ends with
/// one. `None` if none does: the number has no unit.
fn typed_number(text: &str, keys: &[&str]) -> Option<Result<f64, NumberError>> {
    let (quantity, unit) = keys.iter().find_map(|key| Quantity::of_name(key))?;
    Some(quantity.read_with_unit(text, unit.symbol))
}

/// Reads a number that is typed as text at a path; `None` if it is none.
pub(crate) fn typed_number_at(text: &str, path: &str) -> Option<f64> {
    let keys: Vec<&str> = path.rsplit('.').collect();
    typed_number(text, &keys)?.ok()
}

/// Keys that lead to a value, from its own outward; its unit is at the end of one of them.
type Keys<'a> = [&'a str; 3];

/// Keys of a value in a table. A cited number has the unit of its table's key, and so has its spread.
fn keys_within<'a>(key: &'a str, table: &DeTable<'a>, [own, outer, _]: Keys<'a>) -> Keys<'a> {
    let is_apart = table.contains_key("value") && !matches!(key, "value" | "spread");
    if is_apart { [key, "", ""] } else { [key, own, outer] }
}

/// A piece of a document that `serde` can read into a type.
enum Node<'a> {
    Value(&'a Spanned<DeValue<'a>>, &'a Replaced, Keys<'a>),
    Table(&'a DeTable<'a>, Range<usize>, &'a Replaced),
    /// A key or another text.
    Text(&'a str),
    /// Place in the text where a value begins or ends.
    Place(usize),
}

impl<'a> Node<'a> {
    fn span(&self) -> Range<usize> {
        match self {
            Node::Value(value, ..) => value.span(),
            Node::Table(_, span, _) => span.clone(),
            Node::Text(_) | Node::Place(_) => 0..0,
        }
    }

    /// Returns a function that gives an error the place of this node, unless it has one.
    fn blamed(&self) -> impl FnOnce(TomlError) -> TomlError + use<> {
        let span = match self {
            Node::Value(..) | Node::Table(..) => Some(self.span()),
            Node::Text(_) | Node::Place(_) => None,
        };
        move |error| match span {
            Some(span) => error.within(&span),
            None => error,
        }
    }

    fn table(&self) -> Option<(&'a DeTable<'a>, &'a Replaced, Keys<'a>)> {
        match self {
            Node::Table(table, _, replaced) => Some((table, replaced, [""; 3])),
            Node::Value(value, replaced, keys) => value.get_ref().as_table().map(|table| (table, *replaced, *keys)),
            _ => None,
        }
    }

    /// What this node is. Not generic, so that it is compiled once and not for every type of a file.
    fn seen(&self) -> Result<Seen<'a>, TomlError> {
        if let Some((table, replaced, keys)) = self.table() {
            return Ok(Seen::Pairs(Box::new(Pairs::table(table, replaced, keys))));
        }
        Ok(match self {
            Node::Text(text) => Seen::Text(text),
            Node::Place(place) => Seen::Place(*place as u64),
            Node::Table(table, _, replaced) => Seen::Pairs(Box::new(Pairs::table(table, replaced, [""; 3]))),
            Node::Value(value, replaced, keys) => match value.get_ref() {
                DeValue::Integer(_) | DeValue::Float(_) if replaced.numbers.contains_key(&place(value)) => {
                    Seen::Float(replaced.numbers[&place(value)])
                }
                DeValue::String(text) => Seen::Text(text),
                DeValue::Integer(number) => integer(number)?,
                DeValue::Float(number) => Seen::Float(float(number)?),
                DeValue::Boolean(value) => Seen::Boolean(*value),
                DeValue::Array(items) => Seen::Items(Items(items.iter(), replaced, *keys)),
                DeValue::Table(table) => Seen::Pairs(Box::new(Pairs::table(table, replaced, *keys))),
                DeValue::Datetime(_) => Seen::Pairs(Box::new(Pairs::date())),
            },
        })
    }

    /// [`Node::seen`] where a number is expected: it may be typed as text.
    fn seen_number(&self) -> Result<Seen<'a>, TomlError> {
        let Node::Value(value, replaced, keys) = self else { return self.seen() };
        let DeValue::String(text) = value.get_ref() else { return self.seen() };
        if let Some(number) = replaced.numbers.get(&place(value)) {
            return Ok(Seen::Float(*number));
        }
        let (message, expected) = match typed_number(text, keys) {
            Some(Ok(number)) => return Ok(Seen::Float(number)),
            // The type says which numbers it takes.
            None | Some(Err(NumberError::Text { .. })) => return self.seen(),
            Some(Err(NumberError::Unit { unit, known, .. })) => (format!("`{unit}` is not one of its units"), known),
            Some(Err(NumberError::NoUnit { example, known, .. })) => {
                ("a number in quotes needs its unit".to_owned(), format!("`{example}` (units: {known})"))
            }
            Some(Err(NumberError::Comma { decimal, thousands, .. })) => {
                ("this comma may have two meanings".to_owned(), format!("`{decimal}` or `{thousands}`"))
            }
            Some(Err(error)) => (error.to_string(), String::new()),
        };
        Err(TomlError { message, span: Some(value.span()), expected: Some(expected) })
    }
}

impl<'a> Seen<'a> {
    fn visit<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, TomlError> {
        match self {
            Seen::Text(text) => visitor.visit_borrowed_str(text),
            Seen::Place(place) => visitor.visit_u64(place),
            Seen::Float(number) => visitor.visit_f64(number),
            Seen::Integer(number) => visitor.visit_i64(number),
            Seen::Long(number) => visitor.visit_i128(number),
            Seen::Boolean(value) => visitor.visit_bool(value),
            Seen::Items(items) => visitor.visit_seq(items),
            Seen::Pairs(pairs) => visitor.visit_map(*pairs),
        }
    }
}

/// What a node is to `serde`.
enum Seen<'a> {
    Text(&'a str),
    Place(u64),
    Float(f64),
    Integer(i64),
    Long(i128),
    Boolean(bool),
    Items(Items<'a>),
    // In a box, because it is much larger than the others.
    Pairs(Box<Pairs<'a>>),
}

fn integer<'a>(number: &DeInteger<'_>) -> Result<Seen<'a>, TomlError> {
    let (digits, radix) = (number.as_str(), number.radix());
    match i64::from_str_radix(digits, radix) {
        Ok(number) => Ok(Seen::Integer(number)),
        Err(_) => match i128::from_str_radix(digits, radix) {
            Ok(number) => Ok(Seen::Long(number)),
            Err(_) => Err(TomlError::custom("integer number overflowed")),
        },
    }
}

fn float(number: &DeFloat<'_>) -> Result<f64, TomlError> {
    let text = number.as_str();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() || number.is_nan() || text.contains("inf") => Ok(number),
        _ => Err(TomlError::custom("floating-point number overflowed")),
    }
}

impl<'a> Deserializer<'a> for Node<'a> {
    type Error = TomlError;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, TomlError> {
        self.seen().and_then(|seen| seen.visit(visitor)).map_err(self.blamed())
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, TomlError> {
        let blamed = self.blamed();
        visitor.visit_some(self).map_err(blamed)
    }

    fn deserialize_newtype_struct<V: Visitor<'a>>(self, name: &'static str, visitor: V) -> Result<V::Value, TomlError> {
        let blamed = self.blamed();
        if name == NUMBER {
            return self.deserialize_f64(visitor);
        }
        visitor.visit_newtype_struct(self).map_err(blamed)
    }

    fn deserialize_f64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, TomlError> {
        self.seen_number().and_then(|seen| seen.visit(visitor)).map_err(self.blamed())
    }

    fn deserialize_struct<V: Visitor<'a>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        if is_spanned(name) { visitor.visit_map(Pairs::spanned(self, fields)) } else { self.deserialize_any(visitor) }
    }

    fn deserialize_enum<V: Visitor<'a>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, TomlError> {
        let blamed = self.blamed();
        let text: Option<&str> = match &self {
            Node::Text(text) => Some(text),
            Node::Value(value, ..) => value.get_ref().as_str(),
            _ => None,
        };
        let found = match (text, self.table()) {
            (Some(text), _) => {
                let text: StrDeserializer<TomlError> = text.into_deserializer();
                visitor.visit_enum(text)
            }
            (None, Some((table, replaced, keys))) if table.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(Pairs::table(table, replaced, keys)))
            }
            (None, Some(_)) => Err(TomlError::custom("wanted exactly 1 element")),
            (None, None) => Err(TomlError::custom("wanted string or table")),
        };
        found.map_err(blamed)
    }

    forward_to_deserialize_any! {
        <W: Visitor<'a>>
        bool u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 char str string seq bytes byte_buf map unit ignored_any unit_struct tuple_struct tuple
        identifier
    }
}

/// Elements of a list.
struct Items<'a>(std::slice::Iter<'a, Spanned<DeValue<'a>>>, &'a Replaced, Keys<'a>);

impl<'a> Items<'a> {
    fn next_item(&mut self) -> Option<Node<'a>> {
        let Items(items, replaced, keys) = self;
        let next = items.find(|item| !replaced.removed.contains(&place(item)));
        next.map(|item| Node::Value(item, replaced, *keys))
    }
}

impl<'a> SeqAccess<'a> for Items<'a> {
    type Error = TomlError;

    fn next_element_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<Option<T::Value>, TomlError> {
        self.next_item().map(|item| seed.deserialize(item)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// Keys of a table with their values.
type Rows<'a> = toml::map::Iter<'a, Spanned<Cow<'a, str>>, Spanned<DeValue<'a>>>;

/// Keys and values: of a table, with the place of each key, or the pairs by which `serde` receives the place of a
/// value.
struct Pairs<'a> {
    table: Option<(Rows<'a>, &'a Replaced, &'a DeTable<'a>, Keys<'a>)>,
    more: [Option<(&'a str, Node<'a>)>; 3],
    value: Option<Node<'a>>,
}

impl<'a> Pairs<'a> {
    fn table(table: &'a DeTable<'a>, replaced: &'a Replaced, keys: Keys<'a>) -> Self {
        Pairs { table: Some((table.iter(), replaced, table, keys)), more: [const { None }; 3], value: None }
    }

    fn date() -> Self {
        Pairs { table: None, more: [Some((DATE, Node::Text(""))), None, None], value: None }
    }

    /// Pairs of a value with its place: start, end and the value itself.
    fn spanned(node: Node<'a>, fields: &'static [&'static str]) -> Self {
        let Range { start, end } = node.span();
        let mut values = [Some(Node::Place(start)), Some(Node::Place(end)), Some(node)];
        let more = std::array::from_fn(|k| fields.get(k).copied().zip(values[k].take()));
        Pairs { table: None, more, value: None }
    }

    /// The next key and its place, if it has one; its value waits.
    fn next_key(&mut self) -> Option<(&'a str, Option<Range<usize>>)> {
        let next = self.table.as_mut().and_then(|(pairs, replaced, table, keys)| {
            let (key, value) = pairs.find(|(_, value)| !replaced.removed.contains(&place(value)))?;
            Some((key, Node::Value(value, replaced, keys_within(key.get_ref(), table, *keys))))
        });
        if let Some((key, value)) = next {
            self.value = Some(value);
            return Some((key.get_ref().as_ref(), Some(key.span())));
        }
        let (key, value) = self.more.iter_mut().find_map(Option::take)?;
        self.value = Some(value);
        Some((key, None))
    }
}

impl<'a> MapAccess<'a> for Pairs<'a> {
    type Error = TomlError;

    fn next_key_seed<K: DeserializeSeed<'a>>(&mut self, seed: K) -> Result<Option<K::Value>, TomlError> {
        let Some((key, span)) = self.next_key() else { return Ok(None) };
        let found = seed.deserialize(Node::Text(key));
        found.map(Some).map_err(|error| match span {
            Some(span) => error.within(&span),
            None => error,
        })
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, TomlError> {
        let Some(value) = self.value.take() else { return Err(TomlError::custom("a value without a key")) };
        let blamed = value.blamed();
        seed.deserialize(value).map_err(blamed)
    }
}
