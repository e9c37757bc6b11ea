//! The JSON Schema of instrument files, generated from the structs that read them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::format::InstrumentToml;

/// Returns the JSON Schema of instrument files, pretty-printed, with a final newline: the content of
/// `instruments/instrument.schema.json`. It is draft 7, the one that TOML editors know.
pub fn json_schema() -> String {
    schema_of::<InstrumentToml>()
}

/// Returns the JSON Schema of a file format.
pub fn schema_of<T: JsonSchema>() -> String {
    let schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>();
    let mut schema = schema.to_value();
    drop_null(&mut schema);
    // Printing a `Value` cannot fail: its keys are strings.
    serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n"
}

/// Removes `null` everywhere: schemars allows it for every optional value, but TOML has no null.
fn drop_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.values_mut().for_each(drop_null);
            object.retain(|key, value| !(key == "default" && value.is_null()));
            if let Some(Value::Array(types)) = object.get_mut("type") {
                types.retain(|kind| kind != "null");
                if let [kind] = types.as_slice() {
                    let kind = kind.clone();
                    object.insert("type".to_owned(), kind);
                }
            }
            if let Some(Value::Array(choices)) = object.get_mut("anyOf") {
                choices.retain(|choice| choice.get("type").is_none_or(|kind| kind != "null"));
                if choices.len() == 1 {
                    // In draft 7 a bare `$ref` would hide the description beside it.
                    let only = object.remove("anyOf").unwrap_or_default();
                    object.insert("allOf".to_owned(), only);
                }
            }
        }
        Value::Array(values) => values.iter_mut().for_each(drop_null),
        _ => {}
    }
}
