//! Impacts announced before they come.

use erard::Action;
use erard::grand::Anatomy;
use erard::level::LEVELS;
use erard_live::SensorKind;
use erard_live::ahead::Announced;
use erard_live::stream::{Of, Sample};

use crate::common::{GRAND, Press, offs, one_key, ons, played};

/// Presses at every level, a sensor of 12 bits: all are announced, one note each, and what is announced is right to 0.2
/// ms and 1 %. Longest of the shortest leads that a level must have, s.
fn leads(rate: f64, presses: &[Press], phases: u32, least_median_ms: f64) {
    let mut live = one_key(SensorKind::Action, true);
    let mut begins_s = 0.0;
    for press in presses {
        for phase in 0..phases {
            let phase_s = f64::from(phase) / f64::from(phases) / rate;
            let events = played(&mut live, &press.sensed(1, begins_s, rate, phase_s, 10.0 / 4096.0));
            assert_eq!((ons(&events).len(), offs(&events).len()), (1, 1), "{events:?}");
            begins_s += 3.0;
        }
    }
    let report = live.report();
    assert_eq!((report.false_announcements, report.ahead.len()), (0, presses.len()), "{report:?}");
    for lead in &report.ahead {
        println!(
            "{rate} Hz {}: {}/{} lead {:.2} ms, at least {:.2}; errors {:.3} ms, {:.2} %",
            lead.level,
            lead.announced,
            lead.notes,
            lead.median_ms,
            lead.shortest_ms,
            lead.largest_error_ms,
            100.0 * lead.largest_error_of_speed
        );
        assert_eq!((lead.announced, lead.beyond), (lead.notes, 0), "{rate} Hz: {lead:?}");
        assert!(lead.median_ms > least_median_ms && lead.useless == (lead.median_ms < 1.0), "{rate} Hz: {lead:?}");
    }
}

#[test]
fn impacts_are_announced_in_time_and_speed() {
    let presses = [1, 2, 4].map(|i| Press::to(LEVELS[i].1));
    leads(1000.0, &presses, 2, 2.0);
}

#[test]
#[ignore = "ci: five levels, three rates, twenty phases"]
fn impacts_of_all_levels_are_announced() {
    let presses = LEVELS.map(|(_, speed)| Press::to(speed));
    for rate in [1000.0, 2000.0, 4000.0] {
        leads(rate, &presses, 20, 1.0);
    }
}

/// The other way, to wait until the hammer flies free of jack and lever, knows it later at every level.
#[test]
fn a_free_flight_is_shorter() {
    let parts = Anatomy::find(&GRAND).unwrap();
    let bounds = [4.0, 3.0, 2.0, 1.5, 1.0];
    for ((name, speed), most_ms) in LEVELS.into_iter().zip(bounds) {
        let press = Press::to(speed);
        let mut action = Action::new(&GRAND).unwrap();
        let h = action.settings().step;
        let (mut free_s, mut hit_s) = (0.0, None);
        for (n, pair) in press.key_m.windows(2).enumerate() {
            let input = erard::Input::Rigid { position_m: pair[1], velocity_m_per_s: (pair[1] - pair[0]) / h };
            let reading = action.step(input);
            let pushes = |zone: usize| action.contact_force(zone) > 0.0;
            if pushes(parts.jack_knuckle) || parts.lever_knuckle.is_some_and(pushes) {
                free_s = n as f64 * h;
            }
            if let Some(impact) = reading.impact {
                hit_s = Some(impact.time_s);
                break;
            }
        }
        let flight_ms = 1e3 * (hit_s.unwrap() - free_s);
        println!("{name}: free for {flight_ms:.2} ms");
        assert!((0.05..most_ms).contains(&flight_ms), "{name}: {flight_ms}");
    }
}

/// A key that is stopped on its way, where the hammer just reaches the string or just does not: what is announced
/// comes, for a hammer that near flies on. (One that does not come counts as false 5 ms after its instant.)
#[test]
fn stopped_keys_announce_nothing_false() {
    let mut live = one_key(SensorKind::Action, true);
    let (mut begins_s, mut events) = (0.0, Vec::new());
    for (speed, stop_mm) in [54.0, 150.0].into_iter().flat_map(|v| (0..12).map(move |k| (v, 7.0 + 0.2 * f64::from(k))))
    {
        let at = |t: f64| if t > 0.25 { 0.0 } else { (speed * (t - 0.02).max(0.0)).min(stop_mm) };
        let samples: Vec<Sample> = (0..300_u32)
            .map(|k| f64::from(k) * 1e-3)
            .map(|t| Sample { time_s: begins_s + t, of: Of::Key(1), value: at(t) })
            .collect();
        events.extend(played(&mut live, &samples));
        begins_s += 4.0;
    }
    let report = live.report();
    assert!(report.note_ons > 10 && report.false_announcements == 0, "{report:?}");
    assert_eq!((ons(&events).len() as u64, offs(&events).len() as u64), (report.note_ons, report.note_offs));

    let announced = Announced { hit: [1.0, 2.0], known_s: 0.997 };
    assert!(!announced.is_false(1.0049) && announced.is_false(1.0051));
}
