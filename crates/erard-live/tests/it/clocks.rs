//! A sender's clock is a claim.

use erard_live::stream::{Of, Sample};
use erard_live::{Event, Live, SensorKind};
use erard_midi::Velocity;

use crate::common::{GRAND, Press, offs, one_key, ons, options, played};

/// Presses of mf, a second apart, at 1 kHz.
fn presses(count: usize) -> Vec<Sample> {
    let press = Press::to(1.5);
    (0..count).flat_map(|i| press.sensed(1, i as f64, 1000.0, 0.0, 0.0)).collect()
}

fn two_keys() -> Live {
    let grands = [GRAND.clone(), GRAND.clone()];
    Live::new(&grands, None, options(SensorKind::Action, false), &mut |_| true).unwrap()
}

fn releases(events: &[Event]) -> Vec<Option<Velocity>> {
    events
        .iter()
        .filter_map(|event| if let Event::Off { release, .. } = event { Some(*release) } else { None })
        .collect()
}

/// One line with a wrong stamp, ahead or back, costs that line: every note is the same, to the bit.
#[test]
fn a_wrong_stamp_costs_its_line() {
    let samples = presses(5);
    let whole = played(&mut one_key(SensorKind::Action, false), &samples);
    assert_eq!((ons(&whole).len(), offs(&whole).len()), (5, 5));
    for off_s in [10.0, -10.0, 3000.0, 1.5] {
        let mut live = one_key(SensorKind::Action, false);
        let mut wrong = samples.clone();
        // Additional lines, at rest, in the middle of a press, and while the key is held: a scan of one stamp.
        for at in [4200, 2045, 2044, 1300, 20] {
            wrong.insert(at, Sample { time_s: samples[at].time_s + off_s, ..samples[at] });
        }
        assert_eq!(played(&mut live, &wrong), whole, "{off_s}");
        assert_eq!((live.report().dropped_stamps, live.report().stream_gaps, live.report().new_clocks), (5, 0, 0));
    }
}

/// A sender that begins anew, with its header or without, is played at once; what was held ends.
#[test]
fn a_clock_may_begin_anew() {
    let samples = presses(2);
    for has_header in [true, false] {
        let mut live = one_key(SensorKind::Action, false);
        let mut events = Vec::new();
        // It ends within the second press, which is held.
        samples[..1100].iter().for_each(|sample| live.take(sample, &mut |event| events.push(event)));
        assert_eq!((ons(&events).len(), offs(&events).len()), (2, 1));
        if has_header {
            live.restart();
        }
        events.extend(played(&mut live, &samples));
        let (ons, offs, report) = (ons(&events), offs(&events), live.report());
        assert!(ons.len() == 4 && offs.len() == 4 && ons.is_sorted_by(|a, b| a[0] < b[0]), "{has_header}: {events:?}");
        assert_eq!((report.new_clocks, report.dropped_stamps, report.unseen_releases), (1, 0, 1), "{report:?}");
        // The same presses, to a tenth of a count of MIDI: what rubs lets the first begin from another rest.
        for i in 0..2 {
            assert!((ons[i][1] / ons[i + 2][1] - 1.0).abs() < 2e-3, "{ons:?}");
        }
    }
}

/// A gap of the stream ends what is held. It is not simulated, however long it is.
#[test]
fn a_gap_is_not_simulated() {
    let steps = |gap_s: f64| {
        let mut samples = presses(1);
        samples.truncate(300);
        samples.extend(Press::to(1.5).sensed(1, gap_s, 1000.0, 0.0, 0.0));
        let mut live = one_key(SensorKind::Action, false);
        let events = played(&mut live, &samples);
        let report = live.report();
        assert_eq!((ons(&events).len(), offs(&events).len(), report.stream_gaps), (2, 2, 1), "{events:?}");
        // The first ends where it was last seen, and nobody saw its release.
        assert!((offs(&events)[0] - samples[299].time_s).abs() < 2e-3 && releases(&events)[0].is_none(), "{events:?}");
        assert!(releases(&events)[1].is_some() && report.unseen_releases == 1, "{events:?}");
        assert!((ons(&events)[1][0] - gap_s - ons(&events)[0][0]).abs() < 1e-3);
        report.steps
    };
    let (short, long) = (steps(2.0), steps(3000.0));
    assert!(long < short + 100, "{short} {long}");
}

/// A key that is silent while others speak is held as it was, for as long as it takes.
#[test]
fn a_silent_key_is_held_while_others_speak() {
    let held = Press::to(1.5).sensed(1, 0.0, 1000.0, 0.0, 0.0);
    let (down, up) = (&held[..300], &held[300..]);
    let later = up.iter().map(|sample| Sample { time_s: sample.time_s + 4.0, ..*sample });
    let other = (0..4000_u32).map(|k| Sample { time_s: 0.3 + 1e-3 * f64::from(k), of: Of::Key(2), value: 0.0 });
    let samples: Vec<Sample> = down.iter().copied().chain(other).chain(later).collect();
    let mut live = two_keys();
    let events = played(&mut live, &samples);
    assert_eq!((ons(&events).len(), offs(&events).len()), (1, 1), "{events:?}");
    assert!((4.4..4.7).contains(&offs(&events)[0]) && releases(&events)[0].is_some(), "{events:?}");
    assert_eq!(live.report().stream_gaps, 0);
}

/// A stream that ends with a key down ends its note there; nobody saw a release.
#[test]
fn the_end_of_a_stream_is_no_release() {
    let mut samples = presses(1);
    samples.truncate(300);
    let mut live = one_key(SensorKind::Action, false);
    let events = played(&mut live, &samples);
    assert_eq!(releases(&events), [None]);
    assert!((offs(&events)[0] - samples[299].time_s).abs() < 1e-3, "{events:?}");
    assert_eq!(live.report().unseen_releases, 1);
}

/// No note comes without a reason.
#[test]
fn silence_has_a_reason() {
    let of = |value: &dyn Fn(f64) -> f64| {
        let samples: Vec<Sample> = presses(1).iter().map(|one| Sample { value: value(one.value), ..*one }).collect();
        let mut live = one_key(SensorKind::Action, false);
        played(&mut live, &samples);
        live.report().silence
    };
    assert_eq!(of(&|mm| mm), None);
    for (value, part) in [
        (&(|mm: f64| -mm) as &dyn Fn(f64) -> f64, "is the sign inverted"),
        (&|mm| 1e-3 * mm, "are these metres"),
        (&|mm| 0.4 * mm, "no key goes deep enough"),
        (&|_| 0.0, "no key goes deep enough: the largest travel is 0.00 mm"),
    ] {
        let said = of(value).unwrap();
        assert!(said.contains(part), "{part}: {said}");
    }
    // Slowly: half a second down.
    let slow = (0..1500_u32).map(|k| 1e-3 * f64::from(k));
    let slow = slow.map(|t| Sample { time_s: t, of: Of::Key(1), value: (10.0 * t / 1.2).min(9.9) });
    let mut live = one_key(SensorKind::Action, false);
    played(&mut live, &slow.collect::<Vec<_>>());
    let said = live.report().silence.unwrap();
    assert!(said.contains("fast enough"), "{said}");
}
