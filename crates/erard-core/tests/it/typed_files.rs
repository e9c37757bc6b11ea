//! Numbers in files may be typed as text with any unit of their quantity: the file is that of the plain numbers.

use erard::Instrument;
use erard::instrument::{InstrumentFile, numbers_at, with_numbers};
use erard::keyboard::Keyboard;
use erard::parameter::Quantity;
use toml_edit::{DocumentMut, Item, Value};

/// Writes every number whose key ends with a unit as text, with one unit of its quantity after the other.
fn typed(text: &str) -> (String, usize) {
    let mut document: DocumentMut = text.parse().unwrap();
    let mut count = 0;
    for (key, item) in document.iter_mut() {
        type_item(key.get(), item, &mut count);
    }
    (document.to_string(), count)
}

fn type_item(key: &str, item: &mut Item, count: &mut usize) {
    match item {
        Item::Value(value) => type_value(key, value, count),
        Item::Table(table) => table.iter_mut().for_each(|(key, item)| type_item(key.get(), item, count)),
        Item::ArrayOfTables(tables) => {
            for table in tables.iter_mut() {
                table.iter_mut().for_each(|(key, item)| type_item(key.get(), item, count));
            }
        }
        Item::None => {}
    }
}

fn type_value(key: &str, value: &mut Value, count: &mut usize) {
    match value {
        Value::InlineTable(table) => {
            for (inner, value) in table.iter_mut() {
                // A cited number and its spread have the unit of the table's key.
                let is_own = matches!(inner.get(), "value" | "spread");
                type_value(if is_own { key } else { inner.get() }, value, count);
            }
        }
        Value::Array(array) => array.iter_mut().for_each(|value| type_value(key, value, count)),
        value => {
            let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
            let Some((number, (quantity, own))) = number.zip(Quantity::of_name(key)) else { return };
            let unit = &quantity.units()[*count % quantity.units().len()];
            *value = format!("{:e} {}", number * own.si / unit.si, unit.symbol).into();
            *count += 1;
        }
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(1e-9)
}

#[test]
fn instruments_may_be_typed() {
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).unwrap();
        let (typed, count) = typed(text);
        assert!(count > 150, "{name}: {count}");
        let plain = InstrumentFile::parse(text, name).unwrap();
        let read = InstrumentFile::parse(&typed, name).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(plain.provenance.numbers.len(), read.provenance.numbers.len());
        for (a, b) in plain.provenance.numbers.iter().zip(&read.provenance.numbers) {
            assert_eq!(a.key, b.key);
            assert!(a.values.iter().zip(&b.values).all(|(a, b)| close(*a, *b)), "{name}: {a:?} {b:?}");
            // What finds numbers by their paths finds these, too.
            let found = numbers_at(&typed, &b.key);
            let is_found = |found: Vec<f64>| found.iter().zip(&b.values).all(|(a, b)| close(*a, *b));
            assert!(found.is_none_or(is_found), "{name}: {}", b.key);
        }
    }
}

/// Whole units, fractions, commas and trade spellings; what is written is a number.
#[test]
fn spellings_of_one_number_read_alike() {
    let text = Instrument::builtin_text("concert-grand-rigid").unwrap();
    let line = "mass_g = 11.2";
    let body = text.find("name = \"hammer\"").unwrap();
    let place = body + text[body..].find("mass_g").unwrap();
    let end = place + text[place..].find('\n').unwrap();
    let with = |new: &str| format!("{}{new}{}", &text[..place], &text[end..]);
    let plain = Instrument::parse(&with(line), "plain").unwrap();
    for spelling in ["11.2g", "11,2 g", "0.0112 kg", "11200 mg", "+11.2 grams"] {
        let text = with(&format!("mass_g = \"{spelling}\""));
        let read = Instrument::parse(&text, "typed").unwrap_or_else(|error| panic!("{spelling}: {error}"));
        assert_eq!(read, plain, "{spelling}");
        assert_eq!(numbers_at(&text, "body.hammer.mass_g"), Some(vec![11.2]), "{spelling}");
        let changed = with_numbers(&text, &[("body.hammer.mass_g", 0, 12.0)]).unwrap();
        assert!(changed.contains("mass_g = 12"), "{spelling}");
    }
    let error = Instrument::parse(&with("mass_g = \"11.2 mm\""), "file.toml").unwrap_err().to_string();
    assert!(error.starts_with("file.toml:"), "{error}");
    let said = "`body.hammer.mass_g`: `mm` is not one of its units (found `\"11.2 mm\"`, expected kg, g, mg, oz, lb)";
    assert!(error.contains(said), "{error}");
}

/// A key is named by its number or its note.
#[test]
fn keys_are_named_in_files() {
    let text = Instrument::builtin_text("concert-grand").unwrap();
    let of = |key: &str| Instrument::parse(&text.replacen("\nname =", &format!("\nkey = {key}\nname ="), 1), "grand");
    for key in ["1", "\"A0\"", "\"a0\"", "\"1\""] {
        assert_eq!(of(key).unwrap().key(), Some(1), "{key}");
    }
    for key in ["0", "\"H1\"", "89"] {
        let error = of(key).unwrap_err().to_string();
        assert!(error.contains("`key`") && error.contains("or a note from A0 to C8"), "{error}");
    }
    let text = Keyboard::builtin_text("concert-grand").unwrap();
    let named = text.replace("key = 1,", "key = \"A0\",").replace("instrument_key = 40", "instrument_key = \"C4\"");
    assert_ne!(named, text);
    let parse = |text: &str| Keyboard::parse(text, "keyboard", std::path::Path::new("")).unwrap();
    assert_eq!(parse(&named).key(1).unwrap(), parse(text).key(1).unwrap());
}

/// Gradings of a keyboard, and the keys of a keyboard whose base instrument is typed.
#[test]
fn keyboards_may_be_typed() {
    let text = Keyboard::builtin_text("concert-grand").unwrap();
    let (typed, count) = typed(text);
    assert!(count > 10, "{count}");
    let [plain, read] = [text, &typed].map(|text| Keyboard::parse(text, "keyboard", std::path::Path::new("")).unwrap());
    for key in [1, 40, 88] {
        let [plain, read] = [&plain, &read].map(|keyboard| keyboard.key(key).unwrap());
        for (a, b) in plain.bodies.iter().zip(&read.bodies) {
            assert!(close(a.mass_kg, b.mass_kg) && close(a.inertia_kg_m2, b.inertia_kg_m2), "{key}: {}", a.name);
        }
    }
}
