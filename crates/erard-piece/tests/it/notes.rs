//! Each note's hammer comes at its instant with its speed; what cannot be played is explained.

use erard_midi::file::{Note, Piece};
use erard_midi::{Law, Velocity};
use erard_piece::{Fault, Options, Played, Reason, Score};

use crate::common::{HEAVY, RIGID, STRINGS, note, played, score};

/// Half a count and 1 ms: what is promised of a key at home.
fn is_right(note: &Played) -> bool {
    note.louder.is_some_and(|counts| counts.abs() <= 0.5) && note.late_s().is_some_and(|s| s.abs() <= 1e-3)
}

/// From pp to ff on a key with strings: half a count, 1 ms; releases within 1.5 ms.
#[test]
fn notes_from_home_are_as_written() {
    let levels = [44, 90, 20, 60, 110];
    let notes = levels.iter().enumerate().map(|(i, v)| note(40, 0.5 + 1.2 * i as f64, 0.9 + 1.2 * i as f64, *v));
    let performance = played(&score(notes.collect(), Vec::new()), &STRINGS, &Options::default());
    for note in &performance.notes {
        assert!(note.from_home && is_right(note) && note.faults().is_empty(), "{note:?}");
        let [off_s, came_m_per_s] = note.released.unwrap();
        assert!((off_s - note.wanted.off_s).abs() < 1.5e-3 && came_m_per_s > 0.05, "{note:?}");
    }
    // Five levels of nothing known: the brackets close.
    assert!(performance.summary().trials < 40, "{:?}", performance.summary());
}

/// What was right once is known: the same note again needs one trial. (The second does not: the key has been played.)
#[test]
fn a_key_learns() {
    let notes = (0..4).map(|i| note(50, 0.5 + f64::from(i), 0.8 + f64::from(i), 64)).collect();
    let performance = played(&score(notes, Vec::new()), &RIGID, &Options::default());
    let trials: Vec<u32> = performance.notes.iter().map(|note| note.trials).collect();
    assert!(trials[2..] == [1, 1] && performance.notes.iter().all(is_right), "{trials:?}");
}

/// A hand has an end: the loudest note is as loud as it can be, and says so.
#[test]
fn what_is_beyond_reach_is_said() {
    let performance = played(&score(vec![note(1, 0.5, 0.8, 127)], Vec::new()), &RIGID, &Options::default());
    let note = &performance.notes[0];
    let [_, reached_m_per_s] = note.impact.unwrap();
    let why = vec![Reason::TooLoud { reached_m_per_s }];
    assert_eq!((note.faults(), note.reasons()), (vec![Fault::Soft], why), "{note:?}");
    assert!(reached_m_per_s > 4.5 && note.late_s().unwrap().abs() < 1e-3, "{note:?}");
}

/// Velocity 127 on these keys. A law that asks for 12 m/s names each key's ceiling; the note is as loud as that. The
/// published law asks for 8 m/s, which the keys with lower ceilings miss. 3 m/s by a law of one's own are met by all.
fn loudest(keys: &[usize]) {
    let notes = keys.iter().map(|&key| note(key, 0.5, 0.8, 127)).collect();
    let piece = Piece { notes, ..Piece::default() };
    let points = [[0.2, 10.0], [3.0, 127.0]];
    let own = Law::table(&points).unwrap();
    let by = |law: &Law<'_>| played(&Score::of(&piece, law), &RIGID, &Options::default());
    let (linear, published, own) = (by(&Law::Linear { full_m_per_s: 12.0 }), by(&Law::GOEBL), by(&own));
    let ceilings = linear.ceilings();
    println!("{ceilings:.2?}");
    for (note, other) in linear.notes.iter().zip(&published.notes) {
        let reached_m_per_s = ceilings[&note.wanted.key];
        assert!((6.0..10.5).contains(&reached_m_per_s) && note.late_s().unwrap().abs() < 1e-3, "{note:?}");
        assert_eq!((note.faults(), note.reasons()), (vec![Fault::Soft], vec![Reason::TooLoud { reached_m_per_s }]));
        let counts = 127.0 * (reached_m_per_s / 12.0 - 1.0);
        assert!((note.louder.unwrap() - counts).abs() < 1e-9, "{note:?}");
        let missing = 25.0 * (reached_m_per_s / 8.0).log2();
        let is_soft = other.faults() == [Fault::Soft];
        // A hand stops within half a count of what it is asked for.
        assert!(is_soft == (missing < -1.0) || (missing + 1.0).abs() < 0.5, "{missing} {other:?}");
        let same = published
            .ceilings()
            .get(&note.wanted.key)
            .is_none_or(|m_per_s| (m_per_s / reached_m_per_s - 1.0).abs() < 1e-3);
        assert!(same, "{other:?}");
    }
    assert!(own.ceilings().is_empty() && own.notes.iter().all(is_right), "{:?}", own.summary());
}

#[test]
#[ignore = "ci: the loudest note of two keys by three laws"]
fn keys_have_ceilings() {
    loudest(&[40, 88]);
}

mod nightly {
    use erard_piece::{Fault, Reason};

    /// mp and f are as written on ten keys, 5 to 8 a second, but one note of the 80 (key 85, 6.5 a second, 1.03 counts
    /// too loud). At p some are not: a hammer that falls onto the rising
    /// lever is thrown once more, for no check has caught it; at 8 a second a slow hand has no time.
    #[test]
    #[ignore = "nightly: repeated notes of ten keys from p to f"]
    fn repetitions_of_many_keys_are_within_a_count() {
        let keys: Vec<usize> = (4..=88).step_by(9).collect();
        for rate in [5.0, 6.5, 8.0] {
            for level in [66, 93] {
                let wrong = super::repeated(&keys, level, rate);
                let by_little = |note: &super::Played| note.louder.is_some_and(|counts| counts.abs() < 1.1);
                assert!(wrong.len() <= 1 && wrong.iter().all(by_little), "{wrong:?}");
            }
            let wrong = super::repeated(&keys, 44, rate);
            let twice = wrong.iter().filter(|note| note.faults() == [Fault::Twice]);
            assert!(twice.clone().all(|note| note.reasons().contains(&Reason::NotChecked)), "{wrong:?}");
            assert!(twice.clone().count() <= 20 && wrong.len() - twice.count() <= 5, "{wrong:?}");
        }
    }

    #[test]
    #[ignore = "nightly: gaps of 88 keys, four pairs of levels"]
    fn more_time_makes_no_note_of_any_key_worse() {
        for levels in [[40, 110], [100, 35], [60, 60], [90, 90]] {
            // Of 5280 notes each.
            super::monotone(&(1..=88).collect::<Vec<_>>(), levels, 0.1, 10, 5);
        }
    }

    #[test]
    #[ignore = "nightly: the loudest note of 88 keys by three laws"]
    fn every_key_has_a_ceiling() {
        super::loudest(&(1..=88).collect::<Vec<_>>());
    }
}

/// So many notes a second on each key go through the double escapement. Returns the notes that are not within a count
/// and 2 ms, or that sounded twice; each of them is explained.
fn repeated(keys: &[usize], level: u8, rate: f64) -> Vec<Played> {
    let at = |i: i32| 0.5 + f64::from(i) / rate;
    let notes = keys.iter().flat_map(|&key| (0..8).map(move |i| note(key, at(i), at(i) + 0.5 / rate, level)));
    let performance = played(&score(notes.collect(), Vec::new()), &RIGID, &Options::default());
    let later = performance.notes.iter().filter(|note| note.wanted.on_s > 0.5 + 0.5 / rate);
    // A key that is let go early may be home again.
    let home = later.clone().filter(|note| note.from_home).count();
    assert!(10 * home <= later.clone().count() && later.count() == 7 * keys.len(), "{home} from home");
    println!("{level} at {rate}/s: {:?}", performance.summary());
    let wrong: Vec<Played> = performance.notes.into_iter().filter(|note| !note.faults().is_empty()).collect();
    assert!(wrong.iter().all(|note| !note.reasons().is_empty()), "{wrong:?}");
    wrong
}

#[test]
fn repetitions_are_within_a_count() {
    assert!(repeated(&[44], 66, 8.0).is_empty());
}

/// A pair of strokes on each key: velocities, time from the first note's beginning to its end, and from there to the
/// second note's beginning, s. Returns the second notes, key by key.
fn pairs(keys: &[usize], [first, second]: [u8; 2], long_s: f64, gaps_s: &[f64]) -> Vec<Vec<Played>> {
    let notes = keys.iter().flat_map(|&key| {
        gaps_s.iter().enumerate().flat_map(move |(i, gap_s)| {
            let (on_s, off_s) = (0.5 + 2.0 * i as f64, 0.5 + 2.0 * i as f64 + long_s);
            let again_s = off_s + gap_s;
            [note(key, on_s, off_s, first), note(key, again_s, again_s + 0.3, second)]
        })
    });
    let performance = played(&score(notes.collect(), Vec::new()), &RIGID, &Options::default());
    println!("{first} to {second}, {long_s} s long: {:?}", performance.summary());
    let of = |key: usize| performance.notes.iter().filter(move |note| note.wanted.key == key);
    keys.iter().map(|&key| of(key).skip(1).step_by(2).cloned().collect()).collect()
}

/// How far a note is off: counts and milliseconds; one that does not sound is off by 100.
fn off_by(note: &Played) -> f64 {
    note.louder.zip(note.late_s()).map_or(100.0, |(counts, late_s)| counts.abs() + 1e3 * late_s.abs())
}

/// A legato repeat, as every notation program writes it: each note ends where the next begins. The hand lets the key go
/// early enough, and all is as written.
#[test]
fn a_legato_repeat_is_played() {
    let notes = (0..4).map(|i| note(40, 0.5 + 0.5 * f64::from(i), 1.0 + 0.5 * f64::from(i), 112)).collect();
    let performance = played(&score(notes, Vec::new()), &RIGID, &Options::default());
    assert!(performance.notes.iter().all(|note| note.faults().is_empty()), "{performance:?}");
    // It is silent when the next begins, and no earlier than it must be.
    for pair in performance.notes.windows(2) {
        let [off_s, _] = pair[0].released.unwrap();
        assert!((0.05..0.3).contains(&(pair[1].wanted.on_s - off_s)), "{pair:?}");
    }
}

/// A soft note 223 ms after another, whose note-off is 140 to 170 ms before it: the search finds the hand for each.
#[test]
fn the_search_does_not_stop_at_a_local_failure() {
    let rows: Vec<f64> = (140..=170).step_by(3).map(|ms| 1e-3 * f64::from(ms)).collect();
    for gap_s in rows {
        for note in pairs(&[51], [54, 61], 0.223 - gap_s, &[gap_s]).concat() {
            assert!(note.faults().is_empty(), "{gap_s}: {note:?}");
        }
    }
}

/// The result over gaps, in two rows a millisecond apart: with more time no note becomes worse by more than a count, as
/// soon as one was within ten. Below that the action cannot do it, and how it fails is not monotone. A fault has a
/// reason. `exceptions`: how many notes may be worse all the same.
fn monotone(keys: &[usize], levels: [u8; 2], long_s: f64, step_ms: usize, exceptions: usize) {
    let mut worse = Vec::new();
    for shift in [0, 1] {
        let gaps_s: Vec<f64> = (10 + shift..=300 + shift).step_by(step_ms).map(|ms| 1e-3 * ms as f64).collect();
        for (key, row) in keys.iter().zip(pairs(keys, levels, long_s, &gaps_s)) {
            let mut least = f64::INFINITY;
            for (gap_s, note) in gaps_s.iter().zip(&row) {
                let off = off_by(note);
                if least <= 10.0 && off >= least.max(1.0) + 1.0 {
                    worse.push(format!("key {key}, gap {gap_s}: {off} after {least}; {note:?}"));
                }
                assert!(note.faults().is_empty() || !note.reasons().is_empty(), "key {key}, gap {gap_s}: {note:?}");
                least = least.min(off);
            }
            assert!(least < 1.0, "key {key}: {least}");
        }
    }
    println!("{levels:?}: {} worse: {worse:#?}", worse.len());
    assert!(worse.len() <= exceptions, "{levels:?}: {worse:#?}");
}

#[test]
fn more_time_makes_no_note_worse() {
    monotone(&[40], [40, 110], 0.1, 45, 0);
    monotone(&[60], [100, 35], 0.1, 45, 0);
}

#[test]
#[ignore = "ci: gaps of two keys, four pairs of levels"]
fn more_time_makes_no_note_of_two_keys_worse() {
    for levels in [[40, 110], [100, 35], [60, 60], [90, 90]] {
        monotone(&[5, 60], levels, 0.1, 30, 0);
    }
}

/// Sixteen a second are more than an action does: each note that is not as written says how its key stood.
#[test]
fn lost_notes_are_explained() {
    let notes: Vec<Note> =
        (0..10).map(|i| note(44, 0.5 + 0.0625 * f64::from(i), 0.53 + 0.0625 * f64::from(i), 66)).collect();
    let performance = played(&score(notes, Vec::new()), &HEAVY, &Options::default());
    let wrong: Vec<&Played> = performance.notes.iter().filter(|note| !note.faults().is_empty()).collect();
    assert!(wrong.len() >= 5, "{:?}", performance.summary());
    for note in wrong {
        let reasons = note.reasons();
        let is_back = |reason: &Reason| matches!(reason, Reason::KeyNotBack { key_m } if *key_m > 0.5e-3);
        assert!(reasons.iter().any(|one| is_back(one) || matches!(one, Reason::HammerNotDown { .. })), "{note:?}");
    }
}

/// A note within 40 ms of the last one is not tried; it costs nothing, and the key is released when it ends.
#[test]
fn notes_at_once_are_left_out() {
    let notes = (0..5).map(|i| note(44, 0.5 + 0.005 * f64::from(i), 0.503 + 0.005 * f64::from(i), 66)).collect();
    let performance = played(&score(notes, Vec::new()), &RIGID, &Options::default());
    let silent: Vec<bool> = performance.notes.iter().map(|note| note.impact.is_none()).collect();
    assert_eq!(silent, [false, true, true, true, true]);
    assert!(performance.notes[1..].iter().all(|note| note.trials == 0 && note.reasons().contains(&Reason::TooSoon)));
}

/// A written release velocity is a speed of the key where it sets its damper down.
#[test]
fn releases_have_their_speeds() {
    let slow = Note { release: Some(Velocity::of_seven_bits(32)), ..note(40, 0.5, 1.0, 60) };
    let fast = Note { release: Some(Velocity::of_seven_bits(76)), ..note(40, 2.0, 2.5, 60) };
    let performance = played(&score(vec![slow, fast], Vec::new()), &RIGID, &Options::default());
    for (note, wanted) in performance.notes.iter().zip([0.1, 0.2375]) {
        let [off_s, came_m_per_s] = note.released.unwrap();
        assert!((off_s - note.wanted.off_s).abs() < 2e-3, "{note:?}");
        assert!((came_m_per_s / wanted - 1.0).abs() < 0.12, "{came_m_per_s} for {wanted}");
    }
}

/// A piece that begins at once is shifted, all of it; one that does not is left where it is.
#[test]
fn the_first_note_has_a_lead() {
    let at_once = score(vec![note(40, 0.0, 0.3, 30), note(42, 1.0, 1.3, 60)], Vec::new());
    assert_eq!(at_once.shift_s, erard_piece::LEAD_S);
    let performance = played(&at_once, &RIGID, &Options::default());
    assert!(performance.notes.iter().all(is_right) && performance.notes[0].pressed_s > 0.0, "{performance:?}");
    assert_eq!(performance.notes[1].wanted.on_s, 1.0 + erard_piece::LEAD_S);
    assert_eq!(score(vec![note(40, 0.5, 0.8, 30)], Vec::new()).shift_s, 0.0);
}
