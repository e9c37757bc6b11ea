//! The instrument that firmware has compiled in is the built-in one. That it plays the same bits, `.ci/run` asks.

#[path = "../../examples/firmware/source.rs"]
mod source;

/// `cargo run --release -p erard --example firmware > bindings/firmware/src/grand.rs` makes it anew.
#[test]
fn grand_is_the_built_in_one() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bindings/firmware/src/grand.rs");
    let committed = std::fs::read_to_string(path).expect("it reads");
    assert!(
        committed == source::grand(),
        "bindings/firmware/src/grand.rs is not the built-in concert grand; its first lines say how it is made"
    );
}
