//! Any bytes as a stroke file: a series that can be evaluated anywhere or an error, never a panic.
#![no_main]

use erard::stroke::{Cursor, MAX_FORCE_N, Series};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match Series::read(bytes, "fuzz.csv") {
        Ok(series) => {
            let (start, end) = (series.start_s(), series.end_s());
            let mut cursor = Cursor::default();
            for i in -1..=33 {
                let t = start + (end - start) * f64::from(i) / 32.0;
                if let Some(force) = &series.force {
                    assert!(force.at(t, &mut cursor).abs() <= MAX_FORCE_N);
                }
                if let Some(position) = &series.position {
                    let (y, v, a) = position.at(t, &mut cursor);
                    assert!(y.is_finite() && v.is_finite() && a.is_finite());
                }
            }
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
});
