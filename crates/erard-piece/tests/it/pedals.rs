//! Pedals are motions of the dampers.

use erard_midi::Law;
use erard_midi::file::{Piece, Remarks};
use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};
use erard_piece::{FULL_PEDAL_M, Options, Played, Reason, Score, passage};

use crate::common::{STRINGS, foot, kept, note, score};

/// The pedal's lift at an instant, s, and the swing of the bridge's force over the 50 ms before, N.
fn at(rows: &[[f64; 9]], time_s: f64) -> (f64, f64) {
    let within: Vec<&[f64; 9]> = rows.iter().filter(|row| row[0] > time_s - 0.05 && row[0] <= time_s).collect();
    let swing = |f: fn(f64, f64) -> f64, from: f64| within.iter().fold(from, |all, row| f(all, row[7]));
    let swing_n = if within.is_empty() { 0.0 } else { swing(f64::max, f64::MIN) - swing(f64::min, f64::MAX) };
    (within.last().map_or(f64::NAN, |row| row[8]), swing_n)
}

/// The sustain pedal lets a released note ring, half of its way lifts its rail by half; up again it ends the note.
#[test]
fn the_sustain_pedal_holds_notes() {
    let pedals = vec![foot(0.7, SUSTAIN, 127), foot(1.6, SUSTAIN, 64), foot(1.8, SUSTAIN, 0)];
    let notes = vec![note(52, 0.5, 1.0, 80), note(54, 0.5, 1.0, 80)];
    let (_, rang) = kept(&score(notes.clone(), pedals), &STRINGS, &Options::default());
    let (_, alone) = kept(&score(notes, Vec::new()), &STRINGS, &Options::default());
    for key in [52, 54] {
        let [with, without] = [rang.rows(key), alone.rows(key)].map(|rows| at(&rows, 1.5));
        assert_eq!(with.0, FULL_PEDAL_M);
        assert!(with.1 > 20.0 * without.1 && with.1 > 0.1, "{with:?} {without:?}");
        let rows = rang.rows(key);
        assert!((at(&rows, 1.7).0 - FULL_PEDAL_M * 64.0 / 127.0).abs() < 1e-9);
        assert!(at(&rows, 2.4).1 < 0.1 * with.1, "{:?}", at(&rows, 2.4));
        // No faster than a foot that stamps.
        let steps = rows.windows(2).filter(|two| two[1][0] - two[0][0] < 1.5e-3);
        assert!(steps.map(|two| (two[1][8] - two[0][8]).abs()).fold(0.0, f64::max) < 0.51e-3);
    }
}

/// The sostenuto pedal holds the dampers that are up when it goes down, and no others. The soft pedal is remarked.
#[test]
fn the_sostenuto_pedal_holds_what_is_held() {
    let pedals = vec![foot(0.8, SOSTENUTO, 127), foot(0.85, SOSTENUTO, 120), foot(0.9, SOFT, 90)];
    let score = score(vec![note(52, 0.5, 1.0, 80), note(54, 1.1, 1.3, 80)], pedals);
    assert!(score.remarks.iter().any(|remark| remark.contains("soft pedal")), "{:?}", score.remarks);
    let (_, kept) = kept(&score, &STRINGS, &Options::default());
    let [held, other] = [52, 54].map(|key| at(&kept.rows(key), 1.7));
    assert!(held.0 == FULL_PEDAL_M && held.1 > 0.1, "{held:?}");
    assert!(other.0.is_nan() || other.0 == 0.0, "{other:?}");
}

/// A soft note on a string that still sounds under the pedal: the string comes to meet the hammer, and where that
/// leaves the note outside what was written, the report says so.
#[test]
fn a_sounding_string_meets_the_hammer() {
    let pedals = vec![foot(0.1, SUSTAIN, 127)];
    let notes = [0.0, 0.02, 0.04, 0.06].into_iter().enumerate().flat_map(|(i, later_s)| {
        let at_s = 0.5 + 3.0 * i as f64;
        [note(30, at_s, at_s + 0.1, 98), note(30, at_s + 0.47 + later_s, at_s + 1.0, 30)]
    });
    let performance = kept(&score(notes.collect(), pedals), &STRINGS, &Options::default()).0;
    let soft = performance.notes.iter().skip(1).step_by(2).filter(|note| !note.faults().is_empty());
    let swings = |note: &Played| {
        note.reasons().iter().any(|one| matches!(one, Reason::StringSounds { swing_m } if *swing_m > 5e-4))
    };
    assert!(soft.clone().count() > 0 && soft.into_iter().all(swings), "{performance:?}");
}

/// A passage begins where it is asked to, its pedals as they had been left.
#[test]
fn a_passage_is_cut_out() {
    let whole = Piece {
        notes: vec![note(40, 0.5, 1.5, 60), note(42, 2.0, 2.5, 60), note(44, 3.0, 3.5, 60)],
        pedals: vec![foot(0.2, SUSTAIN, 127), foot(1.0, SUSTAIN, 30), foot(2.2, SUSTAIN, 0), foot(5.0, SUSTAIN, 127)],
        remarks: Remarks::default(),
    };
    let part = passage(&whole, 1.5, 3.0);
    assert_eq!(part.notes, [note(42, 0.5, 1.0, 60)]);
    let lifts: Vec<(f64, u8)> = part.pedals.iter().map(|change| (change.time_s, change.value)).collect();
    assert_eq!(lifts[..2], [(0.0, 127), (0.0, 30)]);
    assert!(lifts.len() == 3 && (lifts[2].0 - 0.7).abs() < 1e-12);

    // A soft pedal that was up again before the passage changes nothing in it; one that was down does.
    let soft = |up_s: f64| {
        let pedals = vec![foot(0.1, SOFT, 100), foot(0.2, SOFT, 127), foot(up_s, SOFT, 0)];
        let part = passage(&Piece { pedals, ..whole.clone() }, 1.5, 3.0);
        Score::of(&part, &Law::GOEBL).remarks
    };
    assert!(soft(1.0).is_empty(), "{:?}", soft(1.0));
    assert!(soft(2.2)[0].contains("2 changes, down 1 time, 1 note under it"), "{:?}", soft(2.2));
}

/// A key that sleeps feels no pedal; when its hand comes the rail is where the pedal is, and still.
#[test]
fn a_sleeping_key_finds_the_pedal() {
    let pedals = vec![foot(4.0, SUSTAIN, 127), foot(5.0, SUSTAIN, 0), foot(5.5, SUSTAIN, 127)];
    let score = score(vec![note(52, 0.5, 0.7, 60), note(52, 8.0, 8.2, 60)], pedals);
    let (performance, kept) = kept(&score, &STRINGS, &Options::default());
    let rows = kept.rows(52);
    assert!(!rows.iter().any(|row| (3.9..7.5).contains(&row[0])), "it sleeps");
    let pressed_s = performance.notes[1].pressed_s;
    let early = rows.iter().filter(|row| (pressed_s - 0.01..8.0).contains(&row[0]));
    assert!(early.clone().count() > 50 && early.into_iter().all(|row| row[8] == FULL_PEDAL_M));
    assert!(performance.notes.iter().all(|note| note.faults().is_empty()), "{performance:?}");
}
