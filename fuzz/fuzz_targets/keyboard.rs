//! Any bytes as a keyboard file: a keyboard or an error, never a panic; and keys that are instruments or say why they
//! are not.
#![no_main]

use std::path::Path;

use erard::keyboard::Keyboard;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let helpful = |error: &erard::instrument::FileError| {
        assert!(error.text.get(error.span.clone()).is_some());
        assert!(!error.to_string().contains('\n'));
    };
    match Keyboard::parse_bytes(bytes, "fuzz.toml", Path::new("nowhere")) {
        Ok(keyboard) => {
            for key in [1, keyboard.base_key, 88] {
                if let Err(error) = keyboard.key(key) {
                    helpful(&error);
                }
            }
        }
        Err(error) => helpful(&error),
    }
});
