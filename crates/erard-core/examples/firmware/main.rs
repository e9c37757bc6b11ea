//! Prints the concert grand as Rust source for machines without a heap (`.ci/regenerate firmware`). With the argument
//! `digest` it plays the note of `bindings/firmware/src/play.rs` instead, and says the digest that firmware must find
//! in double precision.

mod source;

use erard_core::saved::{FNV1A, fnv1a};
use erard_core::{Action, Input};

fn main() {
    if std::env::args().nth(1).as_deref() == Some("digest") {
        println!("{:016x}", digest());
    } else {
        print!("{}", source::grand());
    }
}

/// 5 N for a quarter of a second, let go for another; FNV-1a over the bits of all angles.
fn digest() -> u64 {
    let mut action = Action::new(&source::instrument()).expect("it comes to rest");
    for n in 0..10_000 {
        action.step(Input::Force(if n < 5_000 { 5.0 } else { 0.0 }));
    }
    fnv1a(FNV1A, action.angles().iter().flat_map(|angle| angle.to_bits().to_le_bytes()))
}
