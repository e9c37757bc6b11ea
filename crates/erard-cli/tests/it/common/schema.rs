//! JSON Schema, as far as the schemas of answers go.

#![allow(dead_code, reason = "every test program uses a part of it")]

use serde_json::Value;

/// The name of a value's type.
pub fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    }
}

/// Collects the places where a value breaks its schema.
pub fn faults(value: &Value, schema: &Value, path: &str, found: &mut Vec<String>) {
    let schema = schema.as_object().unwrap();
    let known = ["$schema", "title", "type", "required", "properties", "items", "additionalProperties"];
    assert!(schema.keys().all(|key| known.contains(&key.as_str())), "{path}: a keyword that is not checked");
    let types = match schema.get("type") {
        Some(Value::Array(types)) => types.clone(),
        Some(one) => vec![one.clone()],
        None => vec![kind(value).into()],
    };
    if !types.contains(&kind(value).into()) {
        found.push(format!("{path}: {}, not {types:?}", kind(value)));
    }
    if let Value::Object(object) = value {
        for key in schema.get("required").and_then(Value::as_array).into_iter().flatten() {
            if !object.contains_key(key.as_str().unwrap()) {
                found.push(format!("{path}: {key} is missing"));
            }
        }
        for (key, value) in object {
            let own = schema.get("properties").and_then(|all| all.get(key)).or(schema.get("additionalProperties"));
            if let Some(own) = own {
                faults(value, own, &format!("{path}/{key}"), found);
            }
        }
    }
    if let (Value::Array(items), Some(own)) = (value, schema.get("items")) {
        items.iter().enumerate().for_each(|(n, item)| faults(item, own, &format!("{path}/{n}"), found));
    }
}
