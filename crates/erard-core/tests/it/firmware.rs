//! The instrument that firmware has compiled in is the built-in one. That it plays the same bits, `.ci/run` asks.

#[path = "../../examples/firmware/source.rs"]
mod source;

#[test]
fn grand_is_the_built_in_one() {
    crate::common::generated::is_current("bindings/firmware/src/grand.rs", source::grand(), "firmware");
}
