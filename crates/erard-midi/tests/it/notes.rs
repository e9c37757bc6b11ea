//! Keys and hammers as notes.

use erard_midi::{Crossing, Event, KeyNotes, Pedal, key_of_note, note_of_key};

const CROSSING: Crossing = Crossing { damper_m: 4e-3 };

/// A key's way in steps of 1 ms, and impacts: what happened.
fn played(way_mm: &[f64], impacts: &[[f64; 2]]) -> (Vec<Event>, bool) {
    let mut key = KeyNotes::new(CROSSING);
    let mut events = Vec::new();
    for (n, travel) in way_mm.iter().enumerate() {
        let time_s = 1e-3 * n as f64;
        let impact = impacts.iter().find(|[at, _]| time_s - 1e-3 < *at && *at <= time_s);
        events.extend(key.update(time_s, travel * 1e-3, impact.copied()).into_iter().flatten());
    }
    (events, key.sounds())
}

fn off(event: &Event) -> (f64, f64) {
    match *event {
        Event::Off { time_s, release_m_per_s } => (time_s, release_m_per_s.unwrap()),
        Event::On { .. } => panic!("{event:?}"),
    }
}

#[test]
fn a_note_ends_where_the_key_passes_its_damper() {
    let (events, sounds) = played(&[0.0, 5.0, 10.0, 10.0, 7.0, 3.0, 0.0], &[[2.5e-3, 2.0]]);
    assert_eq!(events[0], Event::On { time_s: 2.5e-3, hammer_speed_m_per_s: 2.0 });
    // From 7 to 3 mm in a millisecond: 4 m/s, and 4 mm are passed after 3 of the 4.
    let (time_s, speed) = off(&events[1]);
    assert!((time_s - 4.75e-3).abs() < 1e-12 && (speed - 4.0).abs() < 1e-9, "{events:?}");
    assert_eq!((events.len(), sounds), (2, false));
}

#[test]
fn a_key_that_does_not_strike_makes_no_note() {
    assert_eq!(played(&[0.0, 5.0, 9.0, 5.0, 0.0, 5.0, 0.0], &[]), (vec![], false));
}

/// Up to where it escapes again and down: two note-ons, one note-off.
#[test]
fn a_repetition_is_ended_once() {
    let (events, _) = played(&[0.0, 10.0, 10.0, 6.0, 10.0, 10.0, 0.0], &[[1.5e-3, 2.0], [4.5e-3, 1.0]]);
    let kinds: Vec<bool> = events.iter().map(|event| matches!(event, Event::On { .. })).collect();
    assert_eq!(kinds, [true, true, false]);
}

#[test]
fn a_hammer_that_strikes_after_its_key_has_come_up_leaves_no_note() {
    let (events, sounds) = played(&[0.0, 10.0, 2.0, 0.0, 0.0, 0.0], &[[3.5e-3, 1.0]]);
    assert_eq!(events.len(), 2, "{events:?}");
    assert_eq!((off(&events[1]).0, sounds), (3.5e-3, false));
    // In the very step in which the key passes, on either side of it.
    for (at, order) in [(1.2e-3, [true, false]), (1.9e-3, [true, false])] {
        let (events, sounds) = played(&[0.0, 10.0, 2.0, 0.0], &[[1e-3 + at - 0.0, 1.0]]);
        let kinds: Vec<bool> = events.iter().map(|event| matches!(event, Event::On { .. })).collect();
        assert_eq!((kinds.as_slice(), sounds), (&order[..], false), "{at}");
    }
    // A second note's hammer, after the first note's key has passed: the first one ends before.
    let (events, sounds) = played(&[0.0, 10.0, 10.0, 2.0], &[[1.5e-3, 1.0], [2.9e-3, 1.0]]);
    let kinds: Vec<bool> = events.iter().map(|event| matches!(event, Event::On { .. })).collect();
    assert_eq!((kinds.as_slice(), sounds), (&[true, false, true, false][..], false));
    let times: Vec<f64> = events
        .iter()
        .map(|e| match *e {
            Event::On { time_s, .. } | Event::Off { time_s, .. } => time_s,
        })
        .collect();
    assert!(times.is_sorted(), "{times:?}");
}

/// Whatever a key does, instants ascend, note-offs do not outnumber note-ons, and a note that sounds is one whose key
/// is down.
#[test]
fn whatever_a_key_does_notes_are_in_order() {
    let mut rng = fastrand::Rng::with_seed(34);
    for _ in 0..2000 {
        let mut key = KeyNotes::new(CROSSING);
        let (mut travel, mut last_s, mut on, mut off) = (0.0_f64, 0.0, 0, 0);
        for n in 1..200 {
            travel = (travel + 4e-3 * (rng.f64() - 0.5)).clamp(-1e-3, 10e-3);
            let time_s = 1e-3 * f64::from(n);
            let impact = (rng.f64() < 0.1).then(|| [time_s - 1e-3 * rng.f64(), 1.0]);
            for event in key.update(time_s, travel, impact).into_iter().flatten() {
                let at_s = match event {
                    Event::On { time_s, .. } => {
                        on += 1;
                        time_s
                    }
                    Event::Off { time_s, release_m_per_s } => {
                        off += 1;
                        assert!(release_m_per_s.unwrap() >= 0.0);
                        time_s
                    }
                };
                assert!(last_s <= at_s && at_s <= time_s + 1e-12, "{last_s} {at_s} {time_s}");
                last_s = at_s;
            }
            assert!(off <= on);
            assert!(!key.sounds() || travel > CROSSING.damper_m, "a note of a key that is up");
        }
    }
}

#[test]
fn pedals_are_sent_where_they_change() {
    let mut pedal = Pedal::up();
    assert_eq!(pedal.update(0.0), None);
    assert_eq!(pedal.update(0.5), Some(64));
    assert_eq!(pedal.update(0.501), None);
    assert_eq!(pedal.update(2.0), Some(127));
    assert_eq!(pedal.update(f64::NAN), Some(0));
}

#[test]
fn keys_are_notes() {
    assert_eq!((note_of_key(1), note_of_key(40), note_of_key(88)), (Some(21), Some(60), Some(108)));
    assert_eq!((note_of_key(0), note_of_key(89)), (None, None));
    assert!((0..=127).all(|note| key_of_note(note).is_none_or(|key| note_of_key(key) == Some(note))));
    assert_eq!((key_of_note(20), key_of_note(109)), (None, None));
}
