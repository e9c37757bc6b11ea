//! What earlier versions saved goes on in this one, and in every later one (docs/compatibility.md). The command's tests
//! read the other files of `tests/formats`.

use std::path::{Path, PathBuf};

use erard::{Action, Input, Instrument, Series, Snapshot, SnapshotError};

fn kept(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(file)
}

/// A state that 0.1.0 saved after 400 steps of 50 us under 5 N goes on to the reading that 0.1.0 had 100 steps later.
/// Its instrument is a file that has not changed since 2228d5e4.
#[test]
fn a_saved_state_goes_on() {
    let grand = Instrument::load(&kept("2228d5e4/concert-grand-rigid.toml")).unwrap();
    let state = Snapshot::from_bytes(&std::fs::read(kept("0.1.0/state.bin")).unwrap()).unwrap();
    let mut action = Action::new(&grand).unwrap();
    action.restore(&state).unwrap();
    let reading = (0..100).map(|_| action.step(Input::Force(5.0))).last().unwrap();
    let now = [reading.key_m, reading.hammer_rise_m, reading.hammer_rise_m_per_s];
    assert_eq!(now, [0.005304809012571549, 0.024505238160266396, 2.015565870581175]);
    // It belongs to this instrument alone.
    let other = Instrument::load(&kept("2228d5e4/steinway-o.toml")).unwrap();
    assert_eq!(Action::new(&other).unwrap().restore(&state), Err(SnapshotError::Instrument));
}

/// Titles that were called otherwise are read as those of today.
#[test]
fn earlier_titles_are_read() {
    let text = std::fs::read_to_string(kept("2228d5e4/heavier-f.csv")).unwrap();
    assert!(text.starts_with("time_s,force_N,key_m,hammer_head_m\n"));
    let new = Series::parse(&text.replacen("hammer_head_m", "hammer_rise_m", 1), "new").unwrap();
    assert_eq!(Series::parse(&text, "old").unwrap(), new);
    assert!(new.hammer_head.is_some());
}
