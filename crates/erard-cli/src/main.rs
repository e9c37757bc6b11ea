//! The command `erard`.
fn main() {}
