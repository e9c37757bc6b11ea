//! Scans of sensors, and the truth beside them.

use erard_live::profile::Stops;
use erard_piece::scan::{Case, Reading, Scans, Sensor, Shank, Truth, play_cases, stops};
use erard_piece::{Options, perform};

use crate::common::{RIGID, note, score};

const SENSOR: Sensor = Sensor { bits: 12, rate_hz: 1000.0, noise: 0.0 };

fn cases(cases: &[Case], keys: &[usize], sensors: &[Sensor], threads: usize) -> (Truth, Vec<Vec<Reading>>) {
    let scans = Scans::new(sensors, vec![10e-3; 88], 1);
    let truth = play_cases(&RIGID, (keys, cases), 0.5, 1, &scans, threads, &mut |_| true).unwrap();
    (truth, scans.readings())
}

/// Strikes of the windows of a case.
fn strikes(truth: &Truth, case: Case) -> Vec<Vec<(f64, bool)>> {
    let own = truth.windows.iter().enumerate().filter(|(_, window)| window.case == case.name());
    let of = |index: usize| {
        let strikes = truth.strikes.iter().filter(move |strike| strike.window == index);
        strikes.map(|strike| (strike.hammer_speed_m_per_s, strike.again)).collect()
    };
    own.map(|(index, _)| of(index)).collect()
}

/// Where no string is struck there is no strike; a stroke is one; a brisk spring makes a bounce; a key that is let up
/// slowly strikes when it is pressed again.
#[test]
fn cases_are_what_they_are_called() {
    let all = [Case::HalfStroke, Case::SilentPress, Case::Stroke, Case::Bobbling, Case::Repress];
    let (truth, _) = cases(&all, &[40], &[SENSOR], 2);
    assert!(strikes(&truth, Case::HalfStroke).iter().all(Vec::is_empty), "{truth:?}");
    assert!(strikes(&truth, Case::SilentPress).iter().all(Vec::is_empty), "{truth:?}");
    let strokes: Vec<f64> = strikes(&truth, Case::Stroke).into_iter().flatten().map(|(speed, _)| speed).collect();
    assert!(strokes.len() == 6 && strokes.is_sorted() && strokes[5] > 4.0 * strokes[0], "{strokes:?}");
    let bounced =
        strikes(&truth, Case::Bobbling).iter().filter(|own| matches!(own[..], [(_, false), (_, true)])).count();
    assert!(bounced >= 2, "{truth:?}");
    let again = strikes(&truth, Case::Repress);
    assert!(again.iter().all(|own| matches!(own[..], [(_, false), (_, false)])), "{truth:?}");
    for strike in truth.strikes.iter().filter(|strike| !strike.again) {
        let [off_s, speed] = strike.released.unwrap_or([f64::NAN; 2]);
        let window = &truth.windows[strike.window];
        assert!(off_s > strike.time_s && off_s < window.to_s && speed > 0.0, "{strike:?}");
    }
}

/// Without noise a reading is the key's travel to half a count, key after key within a period; what is sent begins and
/// ends with the rest. Every number of threads gives the same bits.
#[test]
fn readings_follow_the_key() {
    let fine = Sensor { bits: 16, rate_hz: 4000.0, noise: 0.0 };
    let noisy = Sensor { noise: 2e-3, ..SENSOR };
    let (_, all) = cases(&[Case::HalfStroke], &[40, 64], &[SENSOR, fine, noisy], 1);
    assert_eq!(cases(&[Case::HalfStroke], &[40, 64], &[SENSOR, fine, noisy], 2).1, all);
    let travel = |bits: u32, raw: u32| {
        let Stops { rest, pressed } = stops(bits);
        (f64::from(raw) - rest) / (pressed - rest)
    };
    for key in [40, 64] {
        let [coarse, fine, noisy] = [0, 1, 2].map(|which: usize| {
            let own = all[which].iter().filter(|reading| reading.key == key);
            own.map(|reading| (reading.time_us, reading.raw)).collect::<Vec<_>>()
        });
        assert_eq!(coarse[0].1, 410, "the rest: {:?}", coarse[0]);
        assert!(coarse.windows(2).all(|pair| pair[1].0 > pair[0].0 && pair[0].0 % 1000 == coarse[0].0 % 1000));
        let mut square = 0.0;
        for (one, other) in coarse.iter().zip(&noisy) {
            assert_eq!(one.0, other.0);
            square += (travel(12, one.1) - travel(12, other.1)).powi(2);
        }
        let rms = (square / coarse.len() as f64).sqrt();
        assert!((rms / 2e-3 - 1.0).abs() < 0.1, "{rms}");
        // Between two readings of the finer one at a time within 125 us: the key goes less than a count of the coarser.
        for (t, raw) in coarse.iter().filter(|(_, raw)| travel(12, *raw) > 0.01) {
            let near = fine.iter().min_by_key(|(other, _)| other.abs_diff(*t)).unwrap();
            assert!(near.0.abs_diff(*t) <= 126, "{t} {near:?}");
            assert!((travel(12, *raw) - travel(16, near.1)).abs() < 2e-3, "{t} {raw} {near:?}");
        }
    }
}

/// A piece: its strikes are the notes that sounded, and its readings cover the presses.
#[test]
fn a_piece_is_scanned() {
    let score = score(vec![note(40, 0.5, 0.7, 66), note(44, 0.6, 0.8, 50), note(40, 0.9, 1.0, 70)], vec![]);
    let scans = Scans::new(&[SENSOR], vec![10e-3; 88], 1);
    let options = Options { row_s: 0.0, ..Options::default() };
    let played = perform(&score, &RIGID, &options, &|key| Ok(scans.sink(key)), &mut |_| true).unwrap();
    let truth = Truth::of_performance(&played.notes, score.duration_s);
    let struck: Vec<_> = truth.strikes.iter().map(|strike| (strike.key, strike.window, strike.again)).collect();
    assert_eq!(struck, [(40, 0, false), (44, 1, false), (40, 0, false)], "{truth:?}");
    let readings = scans.readings().remove(0);
    for strike in &truth.strikes {
        let down = |reading: &&Reading| {
            let t = 1e-6 * reading.time_us as f64;
            reading.key == strike.key && (t - strike.time_s).abs() < 1e-3 && reading.raw > 2000
        };
        assert!((1..=2).contains(&readings.iter().filter(down).count()), "{strike:?}");
    }
}

/// Sensors at a hammer: at its string as it strikes, below the let-off where it does not.
#[test]
fn hammers_are_scanned() {
    let shank = Shank::of(&RIGID[39]).unwrap();
    assert!((46e-3..49e-3).contains(&shank.unwrap().way_m), "{shank:?}");
    let sensor = Sensor { bits: 16, rate_hz: 10_000.0, noise: 0.0 };
    let mut shanks = vec![None; 88];
    shanks[39] = shank;
    let scans = Scans::of_hammers(&[sensor], shanks, 1);
    let cases = [Case::Stroke, Case::SilentPress];
    let truth = play_cases(&RIGID, (&[40], &cases), 0.5, 1, &scans, 1, &mut |_| true).unwrap();
    let readings = &scans.readings()[0];
    let Stops { rest, pressed } = stops(16);
    let highest = |from_s: f64, to_s: f64| {
        let own = readings.iter().filter(|one| (from_s..to_s).contains(&(1e-6 * one.time_us as f64)));
        own.map(|one| (f64::from(one.raw) - rest) / (pressed - rest)).fold(0.0, f64::max)
    };
    for strike in &truth.strikes {
        let share = highest(strike.time_s - 0.2e-3, strike.time_s + 0.2e-3);
        assert!((share - 1.0).abs() < 0.03, "{share}: {strike:?}");
    }
    assert_eq!(truth.strikes.iter().filter(|strike| !strike.again).count(), 6);
    for window in truth.windows.iter().filter(|window| window.case == "silent-press") {
        let share = highest(window.from_s, window.to_s);
        assert!((0.93..0.995).contains(&share), "{share}: {window:?}");
    }
}

/// Contacts: at every scan those are closed whose depth the key has passed, as a converter that scans at the same
/// instants sees it. With noise they chatter.
#[test]
fn contacts_are_scanned() {
    let played = |scans: Scans| {
        play_cases(&RIGID, (&[40], &[Case::Stroke]), 0.5, 1, &scans, 1, &mut |_| true).unwrap();
        scans.readings()
    };
    let contacts = Sensor { bits: 1, rate_hz: 1000.0, noise: 0.0 };
    let noisy = Sensor { noise: 5e-2, ..contacts };
    let depths_m = [3e-3, 6.5e-3];
    let all = played(Scans::of_contacts(&[contacts, noisy], vec![10e-3; 88], &depths_m, 1));
    let fine = played(Scans::new(&[Sensor { bits: 16, ..contacts }], vec![10e-3; 88], 1));
    let Stops { rest, pressed } = stops(16);
    let mut changes = all[0].iter().peekable();
    let mut closed = 0;
    for Reading { time_us, raw, .. } in &fine[0] {
        if let Some(change) = changes.next_if(|change| change.time_us == *time_us) {
            closed = change.raw;
        }
        let x = 10e-3 * (f64::from(*raw) - rest) / (pressed - rest);
        // But for a key that is within the converter's step of a contact.
        if depths_m.iter().all(|depth_m| (x - depth_m).abs() > 1e-6) {
            let expected = u32::from(x > depths_m[0]) + 2 * u32::from(x > depths_m[1]);
            assert_eq!(closed, expected, "{time_us}: {x}");
        }
    }
    assert_eq!(changes.next(), None, "every change is at a scan");
    assert!(all[0].len() >= 6 * 4 && all[1].len() > all[0].len(), "{} {}", all[0].len(), all[1].len());
}
