//! Any bytes as a MIDI file: notes in order that a keyboard has and a hand can play, or an error, never a panic.
#![no_main]

use erard_midi::file::read;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| match read(bytes) {
    Ok(piece) => {
        let mut ends_s = [0.0_f64; 89];
        let mut last_s = 0.0;
        for note in &piece.notes {
            assert!((1..=88).contains(&note.key) && note.start_s >= last_s && note.end_s.is_finite());
            // Notes of one key follow each other.
            assert!(note.start_s >= ends_s[note.key] && note.end_s >= note.start_s);
            (last_s, ends_s[note.key]) = (note.start_s, note.end_s);
        }
        assert!(piece.pedals.is_sorted_by_key(|change| change.time_s));
        assert!(piece.pedals.iter().all(|change| change.time_s.is_finite() && change.value <= 127));
        assert!(piece.remarks.lines().iter().all(|remark| !remark.contains('\n')));
    }
    Err(error) => assert!(!error.to_string().contains('\n')),
});
