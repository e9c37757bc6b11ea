//! Any bytes as an instrument file: an instrument or an error, never a panic.
#![no_main]

use erard::instrument::InstrumentFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match InstrumentFile::parse_bytes(bytes, "fuzz.toml") {
        Ok(file) => {
            for body in &file.instrument.bodies {
                assert!(body.mass_kg > 0.0 && body.mass_kg.is_finite());
                assert!(body.inertia_kg_m2 > 0.0 && body.inertia_kg_m2.is_finite());
            }
            assert!(file.provenance.numbers.iter().all(|number| !number.key.is_empty()));
        }
        Err(error) => {
            assert!(error.text.get(error.span.clone()).is_some());
            assert!(!error.to_string().contains('\n'));
        }
    }
});
