//! What would throw a hammer too fast is limited before it does; nothing breaks whatever a sensor says.

use erard_live::stream::{Of, Sample};
use erard_live::{MAX_HAMMER_M_PER_S, SensorKind};
use fastrand::Rng;

use crate::common::{offs, one_key, ons, played};

fn sample(t: f64, value: f64) -> Sample {
    Sample { time_s: t, of: Of::Key(1), value }
}

/// Jumps of the whole dip within a sample, forces of a kilonewton: one note each, at the limit, counted.
#[test]
fn jumps_are_limited() {
    for (sensor, value) in [(SensorKind::Action, 10.0), (SensorKind::Light, 10.0), (SensorKind::Force, 1000.0)] {
        let mut live = one_key(sensor, false);
        let samples: Vec<Sample> = (0..500_u32)
            .map(|k| sample(f64::from(k) * 1e-3, if (100..300).contains(&k) { value } else { 0.0 }))
            .collect();
        let events = played(&mut live, &samples);
        let (found, report) = (ons(&events), live.report());
        assert!(found.len() == 1 && offs(&events).len() == 1, "{sensor:?} {events:?}");
        assert!(found[0][1] <= MAX_HAMMER_M_PER_S + 0.01 && found[0][1] > 5.0, "{sensor:?} {found:?}");
        assert!(report.limited_steps > 0 && report.limited_strokes == 1, "{sensor:?} {report:?}");
    }
}

/// Random square waves, ramps and noise never throw a hammer faster than the limit, and end in silence.
fn attacks(seeds: u64) {
    let (mut fastest, mut falses) = (0.0_f64, 0);
    for seed in 0..seeds {
        for sensor in [SensorKind::Action, SensorKind::Light, SensorKind::Force] {
            let (mut random, mut live) = (Rng::with_seed(seed), one_key(sensor, seed % 2 == 0));
            let top = if sensor == SensorKind::Force { 300.0 } else { 12.0 };
            let (mut t, mut value, mut samples) = (0.0, 0.0, Vec::new());
            while t < 1.5 {
                let (target, lasts) = (top * random.f64(), 1e-3 + 0.03 * random.f64().powi(2));
                let (from, begins, is_ramp) = (value, t, random.bool());
                while t < begins + lasts {
                    value = if is_ramp { from + (target - from) * (t - begins) / lasts } else { target };
                    samples.push(sample(t, value + 0.02 * (random.f64() - 0.5)));
                    t += [0.25e-3, 1e-3][random.usize(0..2)];
                }
            }
            let events = played(&mut live, &samples);
            let report = live.report();
            falses += report.false_announcements;
            fastest = fastest.max(report.fastest_hammer_m_per_s);
            assert_eq!(report.non_finite_steps, 0, "{sensor:?} {seed}: {report:?}");
            assert!(report.note_ons > 0 && report.note_offs > 0, "{sensor:?} {seed}: {report:?}");
            // No note is left: after the last note-on there is a note-off.
            let last = [ons(&events).last().unwrap()[0], *offs(&events).last().unwrap()];
            assert!(last[0] <= last[1] + 1e-4, "{sensor:?} {seed}: {last:?}");
            assert!(fastest <= MAX_HAMMER_M_PER_S * 1.01, "{sensor:?} {seed}: {fastest} m/s");
        }
    }
    println!("false {falses}; fastest hammer {fastest:.2} m/s");
}

#[test]
fn no_hammer_is_faster_than_the_limit() {
    attacks(3);
}

#[test]
#[ignore = "ci: twelve seeds on each kind of sensor"]
fn no_hammer_is_faster_than_the_limit_of_a_dozen() {
    attacks(12);
}

mod nightly {
    #[test]
    #[ignore = "nightly: forty seeds on each kind of sensor"]
    fn no_hammer_is_faster_than_the_limit_of_many() {
        super::attacks(40);
    }
}

/// Stalls, sensors that are stuck or noisy, and samples out of order are counted; a key that is held through a stall
/// ends its note.
#[test]
fn faults_of_sensors_are_counted() {
    let mut live = one_key(SensorKind::Action, false);
    let mut events = Vec::new();
    let mut take = |live: &mut erard_live::Live, t: f64, mm: f64| {
        live.take(&sample(t, mm), &mut |event| events.push(event));
    };
    let press = |t: f64| (250.0 * t).min(9.8);
    (0..100_u32).for_each(|k| take(&mut live, f64::from(k) * 1e-3, press(f64::from(k) * 1e-3)));
    // A gap of half a second, and the past.
    take(&mut live, 0.6, 9.8);
    take(&mut live, 0.3, 9.8);
    live.stalled(&mut |event| events.push(event));
    let report = live.report();
    assert_eq!((report.gaps, report.stalls, report.out_of_order), (1, 1, 1), "{report:?}");
    assert_eq!((ons(&events).len(), offs(&events).len()), (1, 1), "{events:?}");
    assert!(report.stuck_keys.is_empty() && report.noisy_keys.is_empty(), "{report:?}");

    let mut live = one_key(SensorKind::Action, false);
    let stuck: Vec<Sample> = (0..1200_u32).map(|k| sample(f64::from(k) * 0.01, 4.0)).collect();
    played(&mut live, &stuck);
    assert_eq!(live.report().stuck_keys, [1]);

    // Jumps that would throw the grand's key off its rail, which plays all the same as one that cannot leave it.
    let mut live = one_key(SensorKind::Action, false);
    let noisy: Vec<Sample> =
        (0..1000_u32).map(|k| sample(f64::from(k) * 1e-3, if k % 10 == 0 { 0.3 } else { 0.0 })).collect();
    let events = played(&mut live, &noisy);
    assert!(live.report().noisy_keys == [1] && ons(&events).is_empty(), "{:?} {events:?}", live.report());
}
