//! Sensed hammers: heads whose motion is known, read at a rate with bits and noise.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use erard::stroke::Touch;
use erard_live::profile::{Profile, Release, Sensed, Stops};
use erard_live::sensor::Law;
use erard_live::stream::{Head, Of, Reader, Sample, SensorUnit};
use erard_live::{Event, Live, Options, Report, SensorKind};

use crate::common::{GRAND, Press, offs, ons, options};

/// Way of the built-in grand's hammer to its string, on its arc, m.
static BLOW_M: LazyLock<f64> = LazyLock::new(|| {
    let soft = Press::to(0.5);
    soft.head(soft.impacts[0][0])
});
/// Readings at a head's stops, of 12 bits; the key's beside.
const STOPS: Stops = Stops { rest: 3500.0, pressed: 500.0 };
const KEY: Stops = Stops { rest: 200.0, pressed: 3200.0 };
/// The second sensor, at the key's front.
const RELEASE: Release = Release { travel_m: 10e-3, off_m: 4.3e-3 };

/// A profile of one hammer.
pub fn profile(has_release: bool) -> Profile {
    let release = has_release.then(|| (RELEASE, BTreeMap::from([(1, KEY)])));
    Profile {
        sensed: Sensed::Hammers(release),
        law: Law::Linear {},
        travel_m: *BLOW_M,
        pressure_is_depth: false,
        keys: BTreeMap::from([(1, STOPS)]),
    }
}

/// What the sensors read of a press, 12 bits: a rate, Hz, a phase, s, noise as a share of the range.
pub fn readings(press: &Press, [rate_hz, phase_s, noise]: [f64; 3], has_release: bool) -> Vec<Sample> {
    let mut random = fastrand::Rng::with_seed(1);
    let mut read = |share: f64, stops: Stops| {
        let normal = (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        (stops.rest + (share + noise * normal) * (stops.pressed - stops.rest)).round()
    };
    let mut all = Vec::new();
    for k in 0..(press.lasts_s() * rate_hz) as u32 {
        let time_s = f64::from(k) / rate_hz + phase_s;
        let value = read(press.head(time_s) / *BLOW_M, STOPS);
        all.push(Sample { time_s, of: Of::Key(1), value });
        if has_release {
            let value = read(press.at(time_s) / RELEASE.travel_m, KEY);
            all.push(Sample { time_s, of: Of::Release(1), value });
        }
    }
    all
}

fn played(profile: &Profile, samples: &[Sample]) -> (Vec<Event>, Report) {
    let options = Options { quantity: SensorUnit::Raw, ..options(SensorKind::Action, false) };
    let mut live = Live::new(std::slice::from_ref(&*GRAND), Some(profile), options, &mut |_| true).unwrap();
    let events = crate::common::played(&mut live, samples);
    (events, live.report())
}

/// Presses from pp to ff by two touches, at a rate and several phases: one note each. Gives the largest errors of the
/// velocity, counts, and of the instant, s.
fn errors(speeds: &[f64], rate_hz: f64, noise: f64, phases: u32) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for touch in [Touch::Pressed, Touch::Struck] {
        for &speed in speeds {
            let press = Press::by(&GRAND, touch, speed);
            for phase in 0..phases {
                let phase_s = f64::from(phase) / f64::from(phases) / rate_hz;
                let (events, report) = played(&profile(false), &readings(&press, [rate_hz, phase_s, noise], false));
                let [[on_s, own]] = ons(&events)[..] else {
                    panic!("{touch:?} {speed} {rate_hz}: {events:?} {report:?}")
                };
                assert_eq!((offs(&events).len(), report.unseen_releases), (1, 1), "{events:?}");
                let [true_s, true_speed] = press.impacts[0];
                worst[0] = worst[0].max((25.0 * (own / true_speed).log2()).abs());
                worst[1] = worst[1].max((on_s - true_s).abs());
            }
        }
    }
    println!("{rate_hz} Hz, noise {noise}: {:.2} counts, {:.3} ms", worst[0], 1e3 * worst[1]);
    worst
}

/// Up to f a slope over the last millimetres gives the speed to a count and a half. At ff the head still accelerates
/// there, and the shank bends.
#[test]
fn a_hammer_at_its_string_is_one_note() {
    assert!((46e-3..49e-3).contains(&*BLOW_M), "{}", *BLOW_M);
    let [counts, instant_s] = errors(&[0.5, 1.0, 2.0, 3.2], 4000.0, 0.0002, 1);
    assert!(counts < 1.5 && instant_s < 0.25e-3, "{counts} {instant_s}");
}

#[test]
#[ignore = "ci: seven speeds, four phases, three rates"]
fn hammers_of_many_speeds_are_one_note_each() {
    for rate_hz in [1000.0, 2000.0, 4000.0, 10_000.0] {
        for noise in [0.0, 0.0005] {
            let [counts, instant_s] = errors(&[0.5, 0.8, 1.3, 2.0, 3.2], rate_hz, noise, 4);
            assert!(counts < 2.5 && instant_s < 0.4e-3, "{rate_hz}: {counts} {instant_s}");
            let [counts, instant_s] = errors(&[5.0], rate_hz, noise, 4);
            assert!(counts < 4.0 && instant_s < 0.4e-3, "{rate_hz}: {counts} {instant_s}");
        }
    }
}

/// A key that is pressed too slowly lifts its hammer to the let-off and no farther; a jack that resets on the way up
/// lifts it again: no note. The same by half a stroke.
#[test]
fn no_note_below_the_let_off() {
    let bottom_m = 10.5e-3;
    let silent = [[2.0, bottom_m], [0.2, bottom_m], [0.3, 0.0]];
    let half = [[0.2, 6e-3], [0.1, 6e-3], [0.2, 0.0]];
    let slow_release = [[0.08, bottom_m], [0.25, bottom_m], [1.5, 0.0]];
    for (path, notes) in [(&silent[..], 0), (&half, 0), (&slow_release, 1)] {
        let press = Press::along(&GRAND, path);
        assert_eq!(press.impacts.len(), notes, "{path:?}");
        for rate_hz in [1000.0, 4000.0] {
            let (events, report) = played(&profile(false), &readings(&press, [rate_hz, 0.0, 0.0005], false));
            assert_eq!((ons(&events).len(), offs(&events).len()), (notes, notes), "{path:?}: {events:?}");
            assert!(report.lifts >= 1, "{path:?}: {report:?}");
            assert_eq!(report.silence.is_some(), notes == 0);
        }
    }
    // Two strokes from half-way are two notes.
    let again = [[0.08, bottom_m], [0.2, bottom_m], [0.2, 3e-3], [0.05, bottom_m], [0.2, bottom_m], [0.1, 0.0]];
    let press = Press::along(&GRAND, &again);
    let (events, _) = played(&profile(false), &readings(&press, [2000.0, 0.0, 0.0002], false));
    assert_eq!((ons(&events).len(), press.impacts.len()), (2, 2), "{events:?}");
}

/// Alone a hammer's note ends by rule, marked; beside a sensor at the key where the damper lies, with its speed.
#[test]
fn releases_are_seen_by_a_second_sensor() {
    let press = Press::to(2.0);
    let alone = played(&profile(false), &readings(&press, [2000.0, 0.0, 0.0], false));
    let beside = played(&profile(true), &readings(&press, [2000.0, 0.0, 0.0], true));
    assert_eq!(ons(&alone.0), ons(&beside.0));
    let up = (1..18_000).rev().map(|k| 50e-6 * f64::from(k)).find(|t| press.at(*t) >= RELEASE.off_m).unwrap();
    let [off_s] = offs(&beside.0)[..] else { panic!("{:?}", beside.0) };
    assert!((off_s - up).abs() < 0.5e-3, "{off_s} {up}");
    assert_eq!((alone.1.unseen_releases, beside.1.unseen_releases), (1, 0));
    let release =
        beside.0.iter().find_map(|event| if let Event::Off { release, .. } = event { *release } else { None });
    let speed = (press.at(up - 1e-3) - press.at(up + 1e-3)) / 2e-3;
    assert!((release.unwrap().counts() - (320.0 * speed).min(127.0)).abs() < 6.0, "{release:?} {speed}");
    // The head is back at a quarter of its way soon after.
    let [late_s] = offs(&alone.0)[..] else { panic!("{:?}", alone.0) };
    assert!((off_s - 0.05..off_s + 0.15).contains(&late_s), "{late_s} {off_s}");
    // A key that is not in the profile, and a second sensor that it does not have.
    let [lost, second] = [Of::Key(2), Of::Release(1)].map(|of| [Sample { time_s: 1.0, of, value: 1.0 }]);
    assert_eq!([&lost, &second].map(|one| played(&profile(false), one).1.uncalibrated), [1, 1]);
}

#[test]
fn a_profile_of_hammers_is_written_and_read() {
    let mut profile = profile(true);
    profile.travel_m = 46e-3;
    let text = profile.text();
    assert_eq!(Profile::parse(&text).unwrap(), profile, "{text}");
    for (from, to, part) in [
        ("\"hammers\"", "\"shanks\"", "`sensed` is \"shanks\"; expected \"keys\" or \"hammers\""),
        ("\"hammers\"", "\"keys\"", "`release` is of 1 keys"),
        ("off_mm = 4.3", "off_mm = 14.3", "off_mm within it"),
        ("release_rest = 200\n", "", "`release of key 1` is None up"),
        ("[release]\ntravel_mm = 10\noff_mm = 4.3", "", "`release` is of 1 keys"),
    ] {
        let fault = Profile::parse(&text.replace(from, to)).unwrap_err().to_string();
        assert!(fault.contains(part), "{to}: {fault}");
    }
    let mut reader = Reader::new(Head::parse("time_us,key,raw").unwrap());
    let at = |of: Of| Ok(Some(Sample { time_s: 1e-6, of, value: 7.0 }));
    assert_eq!((reader.line("1,C4:release,7"), reader.line("1,C4,7")), (at(Of::Release(40)), at(Of::Key(40))));
    assert!(reader.line("1,C9:release,7").unwrap_err().to_string().contains("key is `C9`"));
}
