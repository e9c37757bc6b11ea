//! Rows and sound are the same on any number of threads.

use erard::run::Heard;
use erard_piece::{Block, Options, PerformError, Sample, Silence, perform};

use crate::common::{RIGID, STRINGS, foot, kept, note, score};

/// Rows, sound and notes have the same bits on one and three threads.
#[test]
fn threads_change_no_bit() {
    same_on(&[3]);
}

#[test]
#[ignore = "ci: two and five threads"]
fn no_number_of_threads_changes_a_bit() {
    same_on(&[2, 5]);
}

fn same_on(numbers: &[usize]) {
    let notes = vec![note(40, 0.45, 0.6, 70), note(52, 0.5, 0.7, 50), note(64, 0.55, 0.8, 90), note(40, 0.65, 0.8, 60)];
    let score =
        score(notes, vec![foot(0.5, erard_midi::message::SUSTAIN, 100), foot(0.9, erard_midi::message::SUSTAIN, 0)]);
    let on = |threads: usize| {
        kept(&score, &STRINGS, &Options { threads, sound: Some(Heard::Pressure), ..Options::default() })
    };
    let (first, blocks) = on(1);
    for &threads in numbers {
        let (other, same) = on(threads);
        assert_eq!((&first.notes, first.steps, blocks.blocks()), (&other.notes, other.steps, same.blocks()));
    }
    let any = |is: fn(&Sample) -> bool| move |block: &Block| matches!(block, Block::Sound { samples, .. } if samples.iter().any(is));
    let is_loud = any(|sample| sample.strings.iter().any(|pa| *pa > 0.02));
    let knocks = any(|sample| sample.knocks_n.abs() > 0.02);
    assert!(blocks.blocks().values().all(|all| all.iter().any(is_loud) && all.iter().any(knocks)));
}

/// A row every millisecond while the key is awake, and none while it sleeps.
#[test]
fn keys_sleep_between_notes() {
    let score = score(vec![note(40, 0.5, 0.8, 70), note(40, 20.0, 20.3, 70)], Vec::new());
    let (performance, kept) = kept(&score, &RIGID, &Options::default());
    let rows = kept.rows(40);
    let between = rows.iter().filter(|row| (3.0..19.0).contains(&row[0])).count();
    assert!(between == 0 && rows.len() < 3000, "{between} {}", rows.len());
    assert!(rows.windows(2).all(|two| two[1][0] - two[0][0] > 0.99e-3));
    let gaps = rows.windows(2).filter(|two| two[1][0] - two[0][0] > 1.5e-3).count();
    assert!((1..=6).contains(&gaps), "{gaps}");
    assert!(performance.steps < 200_000, "{}", performance.steps);
    // Every 5 ms there are a fifth of them.
    let fewer = crate::common::kept(&score, &RIGID, &Options { row_s: 5e-3, ..Options::default() }).1.rows(40);
    assert!(fewer.len().abs_diff(rows.len() / 5) <= 4, "{} {}", fewer.len(), rows.len());
}

/// A key that is held for an hour sleeps when it has come to rest, and its release is in time.
#[test]
fn a_key_is_held_for_an_hour() {
    let score = score(vec![note(40, 0.5, 3600.0, 70), note(40, 3601.0, 3601.2, 70)], Vec::new());
    let (performance, kept) = kept(&score, &RIGID, &Options::default());
    assert!(performance.notes.iter().all(|note| note.faults().is_empty()), "{:?}", performance.notes);
    let [off_s, _] = performance.notes[0].released.unwrap();
    assert!((off_s - 3600.0).abs() < 1.5e-3, "{off_s}");
    let rows = kept.rows(40).len();
    assert!(performance.steps < 400_000 && rows < 10_000, "{} steps, {rows} rows", performance.steps);
}

/// A caller who asks to stop is heard at once; a sink that refuses ends the performance.
#[test]
fn it_can_be_ended() {
    let score = score((0..50).map(|i| note(40, 0.5 + f64::from(i), 0.8 + f64::from(i), 70)).collect(), Vec::new());
    let options = Options { threads: 2, ..Options::default() };
    let ended = perform(&score, &RIGID, &options, &|_| Ok(Box::new(Silence)), &mut |_| false);
    assert!(matches!(ended, Err(PerformError::Work(_))), "{ended:?}");
    let refused = perform(&score, &RIGID, &options, &|_| Err(std::io::Error::other("full")), &mut |_| true);
    assert!(matches!(refused, Err(PerformError::Sink(_))), "{refused:?}");
    let missing = perform(&score, &RIGID[..20], &options, &|_| Ok(Box::new(Silence)), &mut |_| true);
    assert!(matches!(missing, Err(PerformError::NoInstrument { key: 40 })), "{missing:?}");
}

/// A note's slow motion is the note: the same speed at the string.
#[test]
fn a_moment_is_the_note() {
    let score = score(vec![note(40, 0.5, 0.7, 70), note(40, 0.66, 0.8, 64)], Vec::new());
    let options = Options { moments: 4, ..Options::default() };
    let (performance, _) = kept(&score, &STRINGS, &options);
    assert_eq!(performance.moments.len(), 2);
    for moment in &performance.moments {
        let [at_s, speed] = performance.notes[moment.note].impact.unwrap();
        let run = moment.run(&STRINGS[39], performance.step_s, &mut |_| true).unwrap();
        let impact = run.events.impacts[0];
        assert!((impact.hammer_speed_m_per_s - speed).abs() < 1e-9, "{speed} {impact:?}");
        assert!((impact.time_s + moment.pressed_s - at_s).abs() < 1e-9, "{at_s} {impact:?}");
    }
}
