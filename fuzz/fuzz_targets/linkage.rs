//! Any bytes as a linkage file: levers or an error, never a panic; and levers that move or say why they do not.
#![no_main]

use erard_kinematics::LinkageFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match LinkageFile::parse_bytes(bytes, "fuzz.toml") {
        Ok(file) => {
            assert!(file.levers.lengths.to_array().iter().all(|length| length.is_finite()));
            if let Ok(case) = file.design().and_then(|design| design.case(&[], Default::default())) {
                let stroke = case.stroke(0.0, 0.010, 5);
                assert!(stroke.poses.iter().all(|pose| pose.residual < 1e-12));
            }
        }
        Err(error) => {
            assert!(error.text.get(error.span.clone()).is_some());
            assert!(!error.to_string().contains('\n'));
        }
    }
});
