//! The answer of `erard check` on a file of any kind.

use serde_json::{Map, Value, json};

/// The answer: what a file is, what it is called, what it holds how many of.
pub(super) fn checked<const N: usize>(kind: &str, file: &str, name: Option<&str>, counts: [(&str, usize); N]) -> Value {
    let counts: Map<String, Value> = counts.into_iter().map(|(what, count)| (what.to_owned(), count.into())).collect();
    let mut checked = json!({"kind": kind, "file": file, "counts": counts});
    if let Some(name) = name {
        checked["name"] = name.into();
    }
    checked
}
