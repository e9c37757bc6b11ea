//! Digests that must be the same on every target, for the loader to ask for one by one.

#[path = "../../common/mod.rs"]
mod common;

use common::digests;

/// What is built in, as loaded here.
#[unsafe(no_mangle)]
pub extern "C" fn loaded() -> u64 {
    digests::loaded()
}

/// The same on the machine that the tests run on.
#[unsafe(no_mangle)]
pub extern "C" fn loaded_expected() -> u64 {
    digests::LOADED
}

/// Twelve notes, played here.
#[unsafe(no_mangle)]
pub extern "C" fn long_run() -> u64 {
    digests::long_run()
}

/// The same on the machine that the tests run on.
#[unsafe(no_mangle)]
pub extern "C" fn long_run_expected() -> u64 {
    digests::GOLDEN
}

/// Twelve notes of the grand that bends, played here.
#[unsafe(no_mangle)]
pub extern "C" fn long_bending_run() -> u64 {
    digests::long_bending_run()
}

/// The same on the machine that the tests run on.
#[unsafe(no_mangle)]
pub extern "C" fn long_bending_run_expected() -> u64 {
    digests::BENDING
}

/// Three hands on the rigid grand, played here.
#[unsafe(no_mangle)]
pub extern "C" fn long_hand_run() -> u64 {
    digests::long_hand_run()
}

/// The same on the machine that the tests run on.
#[unsafe(no_mangle)]
pub extern "C" fn long_hand_run_expected() -> u64 {
    digests::HANDS
}

/// The built-in touches at three levels, found and played here.
#[unsafe(no_mangle)]
pub extern "C" fn long_level_run() -> u64 {
    digests::long_level_run()
}

/// The same on the machine that the tests run on.
#[unsafe(no_mangle)]
pub extern "C" fn long_level_run_expected() -> u64 {
    digests::LEVELS_PLAYED
}
