//! Changes numbers in the text of an instrument file. Comments and layout stay.

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value, value};

use super::from_toml::typed_number_at;

/// Certainty of every number that is written, because the program computed it.
const CERTAINTY: &str = "estimate";

/// Returns the item at a path. Tables of a list are distinguished by their `name`, as in `zone`, `string`, `felt`,
/// `exponent`.
pub(crate) fn find<'d>(table: &'d mut dyn TableLike, path: &[&str]) -> Option<&'d mut Item> {
    let (first, rest) = path.split_first()?;
    let item = table.get_mut(first)?;
    let Some((second, beyond)) = rest.split_first() else { return Some(item) };
    let is_it = |table: &dyn TableLike| table.get("name").and_then(Item::as_str) == Some(*second);
    match item {
        Item::ArrayOfTables(tables) => find(tables.iter_mut().find(|t| is_it(*t))?, beyond),
        Item::Value(Value::Array(tables)) => {
            find(tables.iter_mut().filter_map(Value::as_inline_table_mut).find(|t| is_it(*t))?, beyond)
        }
        _ => find(item.as_table_like_mut()?, rest),
    }
}

/// Returns a number, or the components of a vector, bare or cited, in the unit at the end of its key. `key` may be the
/// path that leads to it.
pub(crate) fn numbers(item: &Item, key: &str) -> Option<Vec<f64>> {
    let item = item.as_table_like().map_or(Some(item), |cited| cited.get("value"))?;
    let number = |value: &Value| match value {
        Value::String(text) => typed_number_at(text.value(), key),
        value => value.as_float().or_else(|| value.as_integer().map(|n| n as f64)),
    };
    match item.as_value()? {
        Value::Array(array) => array.iter().map(number).collect(),
        single => Some(vec![number(single)?]),
    }
}

/// Replaces a number by a cited one. A comment behind it stays.
pub(crate) fn set(item: &mut Item, new: impl Into<Value>, source: &str, note: &str) {
    let new = new.into();
    if let Some(cited) = item.as_table_like_mut() {
        cited.insert("value", value(new));
        cited.insert("source", value(source));
        cited.insert("certainty", value(CERTAINTY));
        cited.insert("note", value(note));
        // The spread belonged to the old number.
        cited.remove("spread");
        cited.remove("spread_factor");
        cited.remove("together");
        return;
    }
    let mut cited = InlineTable::new();
    cited.insert("value", new);
    cited.insert("source", source.into());
    cited.insert("certainty", CERTAINTY.into());
    cited.insert("note", note.into());
    let mut cited = Value::InlineTable(cited);
    if let Some(old) = item.as_value() {
        *cited.decor_mut() = old.decor().clone();
    }
    *item = Item::Value(cited);
}

/// Returns a name for a source: `stem`, or `stem-2` and so on if another author's source has that name. A source by the
/// same `author` is used again.
pub(crate) fn source_name(document: &DocumentMut, stem: &str, author: &str) -> String {
    let taken = |name: &str| {
        let source = document.get("sources").and_then(|sources| sources.get(name));
        source.is_some_and(|source| source.get("author").and_then(Item::as_str) != Some(author))
    };
    let others = (2..).map(|n| format!("{stem}-{n}"));
    std::iter::once(stem.to_owned()).chain(others).find(|name| !taken(name)).unwrap_or_default()
}

/// Adds a source to `[sources]`, or gives an existing one a new title.
pub(crate) fn cite(document: &mut DocumentMut, name: &str, title: &str, author: &str) {
    let sources = document.entry("sources").or_insert_with(|| {
        let mut sources = Table::new();
        sources.set_implicit(true);
        Item::Table(sources)
    });
    let Some(sources) = sources.as_table_like_mut() else { return };
    if let Some(source) = sources.get_mut(name).and_then(Item::as_table_like_mut) {
        source.insert("title", value(title));
        return;
    }
    let mut source = Table::new();
    source.insert("title", value(title));
    source.insert("author", value(author));
    if sources.iter().all(|(_, other)| other.is_table()) {
        source.decor_mut().set_prefix("\n");
        sources.insert(name, Item::Table(source));
    } else {
        sources.insert(name, value(source.into_inline_table()));
    }
}
