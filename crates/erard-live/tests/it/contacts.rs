//! Contacts under a key: edges to notes, and the table of the time between them.

use std::sync::LazyLock;

use erard::Instrument;
use erard::stroke::Touch;
use erard_live::contact_table::{Presses, error_counts};
use erard_live::contacts::{ContactFault, ContactKey, ContactLaw, Point, SpeedTable};
use erard_live::profile::Profile;
use erard_live::stream::{Head, Of, Reader, Sample, SensorUnit};
use erard_live::{Event, Live, Options, Report, SensorKind};
use erard_midi::Event as KeyEvent;

use crate::common::{GRAND, Press, offs, ons, options};

static PRESSES: LazyLock<Presses> = LazyLock::new(|| Presses::of(&GRAND, &mut |_| true).unwrap());
/// Counts of velocity of a hammer speed, m/s.
fn counts(speed: f64) -> f64 {
    52.0 + 25.0 * speed.log2()
}

/// Edges of contacts at these depths, m, as a scan of a period sees a press: a contact that changes chatters for a
/// millisecond.
pub fn edges(press: &Press, depths_m: &[f64], period_s: f64, phase: f64) -> Vec<Sample> {
    let (mut all, mut was) = (Vec::new(), vec![false; depths_m.len()]);
    let mut changed_s = vec![-1.0; depths_m.len()];
    for k in 0..(0.9 / period_s) as u32 {
        let time_s = period_s * (f64::from(k) + phase);
        for (contact, depth_m) in depths_m.iter().enumerate() {
            let is_made = press.at(time_s) >= *depth_m;
            if is_made != (press.at(time_s - period_s) >= *depth_m) {
                changed_s[contact] = time_s;
            }
            // At every second scan after the change it is as before.
            let since = ((time_s - changed_s[contact]) / period_s).round();
            let chatters = since * period_s < 1e-3 && since % 2.0 == 1.0;
            let seen = is_made != chatters;
            if seen != was[contact] {
                was[contact] = seen;
                let value = f64::from(u8::from(seen));
                all.push(Sample { time_s, of: Of::Contact(1, contact), value });
            }
        }
    }
    all
}

fn live(law: &ContactLaw) -> Live {
    let profile = Profile::of_contacts(*law);
    let options = Options { quantity: SensorUnit::Contacts, ..options(SensorKind::Action, false) };
    Live::new(std::slice::from_ref(&*GRAND), Some(&profile), options, &mut |_| true).unwrap()
}

fn played(law: &ContactLaw, samples: &[Sample]) -> (Vec<Event>, Report) {
    let mut live = live(law);
    let events = crate::common::played(&mut live, samples);
    (events, live.report())
}

/// Presses of an instrument by two touches from pp to ff, scanned at several phases: one note each, its speed within
/// the errors that the table states, its end where the upper contact opens. Gives the largest error, counts.
fn one_note_each(instrument: &Instrument, speeds: &[f64], depths_m: &[f64], phases: u32, beyond: f64) -> f64 {
    let period_s = 250e-6;
    let law = PRESSES.law(depths_m, period_s, 2e-3).unwrap();
    let mut worst: f64 = 0.0;
    for touch in [Touch::Pressed, Touch::Struck] {
        for &speed in speeds {
            let press = Press::by(instrument, touch, speed);
            for phase in 0..phases {
                let samples = edges(&press, depths_m, period_s, f64::from(phase) / f64::from(phases));
                let (events, report) = played(&law, &samples);
                let ([[on_s, own]], [off_s]) = (&ons(&events)[..], &offs(&events)[..]) else {
                    panic!("{touch:?} {speed}: {events:?}")
                };
                assert!(report.bounces >= 4 && report.unseen_releases == 0, "{report:?}");
                let off_by = (counts(*own) - counts(speed)).abs();
                let stated = |upper: usize| {
                    let table = &law.tables()[upper];
                    let at = table.points().iter().min_by(|a, b| {
                        let far = |one: &Point| (one.hammer_speed_m_per_s / own).ln().abs();
                        far(a).total_cmp(&far(b))
                    });
                    let at = at.unwrap();
                    at.touch_counts + 2.5 * table.time_counts(at.between_s, period_s)
                };
                let most = (0..law.tables().len()).map(stated).fold(0.0, f64::max);
                assert!(off_by < most + beyond, "{touch:?} {speed}: {own}, {off_by:.2} of {most:.2} counts");
                // The stream begins at an arbitrary instant; the impact's instant is right to the spread of its delay.
                let true_s = press.impacts[0][0];
                assert!((on_s - true_s).abs() < 6e-3, "{touch:?} {speed}: {on_s} for {true_s}");
                // Up through the contact whose opening ends the note.
                let depth_m = law.depths_m[law.off];
                let up_s = (1..17_000).rev().map(|k| 50e-6 * f64::from(k)).find(|t| press.at(*t) >= depth_m).unwrap();
                assert!((off_s - up_s).abs() < 2.0 * period_s, "{off_s} for {up_s}");
                worst = worst.max(off_by);
            }
        }
    }
    println!("{depths_m:?}: {worst:.1} counts at most");
    worst
}

#[test]
fn a_press_is_one_note() {
    one_note_each(&GRAND, &[0.5, 2.0, 4.0], &[3e-3, 6.5e-3], 1, 1.0);
    one_note_each(&GRAND, &[0.5, 2.0, 4.0], &[2.5e-3, 5e-3, 8.5e-3], 1, 1.0);
}

#[test]
#[ignore = "ci: eight speeds, four phases, three pairs of depths, keys at both ends"]
fn presses_of_many_speeds_are_one_note_each() {
    let speeds = [0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.0];
    for depths_m in [&[3e-3, 6.5e-3][..], &[3e-3, 8.5e-3], &[2e-3, 5e-3, 8e-3]] {
        one_note_each(&GRAND, &speeds, depths_m, 4, 1.5);
    }
    // Other keys than the one that was pressed: heavier and lighter hammers.
    let keyboard = erard::keyboard::Keyboard::builtin("concert-grand").unwrap();
    for key in [16, 64] {
        one_note_each(&keyboard.key(key).unwrap(), &[0.7, 1.4, 2.8], &[3e-3, 8.5e-3], 2, 4.0);
    }
}

/// Speed in proportion to the inverse of the time, fitted to all of them, errs by tens of percents between touches and
/// levels; the table errs by what it states.
#[test]
fn the_inverse_of_the_time_is_no_law() {
    let table = PRESSES.table(3e-3, 6.5e-3).unwrap();
    let products: Vec<f64> = table.points().iter().map(|one| one.between_s * one.hammer_speed_m_per_s).collect();
    let [least, most] = [f64::min, f64::max].map(|pick| products.iter().copied().reduce(pick).unwrap());
    assert!(most / least > 1.4, "{products:?}");
    // Contacts that lie farther apart err less by time, deeper ones less by touch: the best are no usual pair.
    let ([upper_m, lower_m], counts) = PRESSES.best(1e-3).unwrap();
    println!("{upper_m} {lower_m} {counts}");
    assert!(counts < error_counts(&table, 1e-3) && lower_m > upper_m && lower_m < PRESSES.dip_m);
    let slow = PRESSES.best(20e-3).unwrap();
    assert!(slow.1 > counts && slow.0[1] - slow.0[0] >= lower_m - upper_m, "{slow:?}");
    assert!(PRESSES.table(3e-3, 12e-3).is_err() && PRESSES.table(6e-3, 3e-3).is_err());
}

/// A table of which 1 m/s are 10 ms, in proportion to the inverse.
fn inverse() -> SpeedTable {
    let point =
        |between_s: f64| Point { between_s, hammer_speed_m_per_s: 0.01 / between_s, delay_s: 1e-3, touch_counts: 0.0 };
    SpeedTable::new(&[point(2e-3), point(50e-3)]).unwrap()
}

/// Contacts of that table.
pub fn law(count: usize) -> ContactLaw {
    let deep =
        SpeedTable::new(&inverse().points().iter().map(|one| Point { touch_counts: 5.0, ..*one }).collect::<Vec<_>>());
    ContactLaw {
        depths_m: [2e-3, 5e-3, 8e-3],
        count,
        tables: [inverse(), deep.unwrap()],
        period_s: 0.0,
        phases_s: [0.0; 3],
        bounce_s: 2e-3,
        off: 0,
    }
}

/// Edges in milliseconds, contact from 1, as text; the events in text.
fn told(law: &ContactLaw, edges: &[(f64, usize, &str)]) -> (Vec<String>, ContactKey) {
    let (mut key, mut events) = (ContactKey::new(), Vec::new());
    let mut send = |event: KeyEvent| {
        events.push(match event {
            KeyEvent::On { time_s, hammer_speed_m_per_s } => {
                format!("on {:.1} {hammer_speed_m_per_s:.3}", 1e3 * time_s)
            }
            KeyEvent::Off { time_s, release_m_per_s } => {
                format!("off {:.1} {}", 1e3 * time_s, release_m_per_s.map_or("-".into(), |v| format!("{v:.3}")))
            }
        });
    };
    for &(ms, contact, state) in edges {
        key.take(law, (contact - 1, 1e-3 * ms, state == "made"), &mut send);
    }
    key.until(law, 10.0, &mut send);
    (events, key)
}

#[test]
fn edges_are_notes_by_rule() {
    let two = law(2);
    let press = [(0.0, 1, "made"), (10.0, 2, "made"), (100.0, 2, "open"), (115.0, 1, "open")];
    // 3 mm in 15 ms.
    assert_eq!(told(&two, &press).0, ["on 11.0 1.000", "off 115.0 0.200"]);
    // Bounces are one edge, the first one.
    let bouncing = [
        (0.0, 1, "made"),
        (0.5, 1, "open"),
        (1.0, 1, "made"),
        (10.0, 2, "made"),
        (10.3, 2, "open"),
        (10.4, 2, "made"),
        (100.0, 2, "open"),
        (115.0, 1, "open"),
        (115.2, 1, "made"),
        (115.4, 1, "open"),
    ];
    let (events, key) = told(&two, &bouncing);
    assert_eq!((&events[..], key.counts.bounces), (&["on 11.0 1.000".into(), "off 115.0 0.200".into()][..], 6));
    // A release within the bounces of the contact below has no speed.
    let short = [(0.0, 1, "made"), (10.0, 2, "made"), (11.0, 2, "open"), (11.5, 1, "open")];
    assert_eq!(told(&two, &short).0, ["on 11.0 1.000", "off 11.5 -"]);
    // Again from half-way: two contacts have no time for it, three have.
    let again = [(120.0, 2, "made"), (300.0, 2, "open"), (315.0, 1, "open")];
    let half_way = [&press[..3], &again].concat();
    let (events, key) = told(&two, &half_way);
    assert_eq!((events.len(), key.counts.untimed), (2, 1), "{events:?}");
    let three = law(3);
    let whole = [
        (0.0, 1, "made"),
        (5.0, 2, "made"),
        (10.0, 3, "made"),
        (100.0, 3, "open"),
        (110.0, 2, "open"),
        (150.0, 2, "made"),
        (155.0, 3, "made"),
        (300.0, 3, "open"),
        (310.0, 2, "open"),
        (320.0, 1, "open"),
    ];
    // The first from the contact that errs least, the second from the one that was opened.
    assert_eq!(told(&three, &whole).0, ["on 11.0 1.000", "on 156.0 2.000", "off 320.0 0.300"]);
    // Too slow, never closed above, in the wrong order, and what was let go.
    assert_eq!(told(&two, &[(0.0, 1, "made"), (60.0, 2, "made")]).1.counts.slow, 1);
    assert_eq!(told(&two, &[(0.0, 2, "made"), (20.0, 1, "made")]).1.counts.swapped, 1);
    let (mut key, mut last) = (ContactKey::new(), None);
    for (ms, contact) in [(0.0, 0), (10.0, 1)] {
        key.take(&two, (contact, 1e-3 * ms, true), &mut |event| last = Some(event));
    }
    key.let_go(1.0, &mut |event| last = Some(event));
    assert_eq!(last, Some(KeyEvent::Off { time_s: 1.0, release_m_per_s: None }));
    assert!(key.is_up());
    // A contact that is read later than its stamp says.
    let phased = ContactLaw { period_s: 1e-3, phases_s: [0.0, 0.5e-3, 0.0], ..two };
    assert_eq!(told(&phased, &[(0.0, 1, "made"), (9.5, 2, "made")]).0, ["on 10.5 1.000"]);
}

/// Speeds between the points of a table, and the error of a time that a scan rounds.
#[test]
fn a_table_is_straight_in_logarithms() {
    let table = inverse();
    let speed = |ms: f64| table.at(1e-3 * ms).map(|one| one.hammer_speed_m_per_s);
    assert!((speed(20.0).unwrap() - 0.5).abs() < 1e-12 && (speed(1.0).unwrap() - 5.0).abs() < 1e-12);
    assert_eq!((speed(51.0), speed(f64::NAN)), (None, None));
    // A hundred thousand scans, each of which sees two edges that are 10 ms apart at the next tick of its own phase.
    let mut random = fastrand::Rng::with_seed(1);
    let square = |_: u32| {
        // The scan's ticks lie anywhere, and the edges' distance, 10 ms, is off by what their phases leave.
        let (apart_ms, from_ms) = (9.5 + random.f64(), random.f64());
        let seen_ms = (from_ms + apart_ms).ceil() - from_ms.ceil();
        (25.0 * (apart_ms / seen_ms).log2()).powi(2)
    };
    let found = ((0..100_000).map(square).sum::<f64>() / 1e5).sqrt();
    let stated = table.time_counts(10e-3, 1e-3);
    assert!((found / stated - 1.0).abs() < 0.05, "{found} {stated}");
    let point = |between_s: f64, hammer_speed_m_per_s: f64| Point {
        between_s,
        hammer_speed_m_per_s,
        delay_s: 0.0,
        touch_counts: 0.0,
    };
    assert_eq!(SpeedTable::new(&[point(1e-3, 1.0)]), Err(ContactFault::Points(1)));
    for bad in [point(1e-3, 0.5), point(2e-3, 1.0), point(2e-3, f64::NAN), point(2e-3, -1.0)] {
        assert_eq!(SpeedTable::new(&[point(1e-3, 1.0), bad]), Err(ContactFault::Point(1)), "{bad:?}");
    }
    assert_eq!(SpeedTable::new(&[point(1e-3, 9.0), point(2e-3, 1.0)]), Err(ContactFault::Point(0)));
}

/// What is written reads back, to its rounding; a maker's own table is one line of it; faults name their entry.
#[test]
fn a_profile_of_contacts_is_written_and_read() {
    let law = ContactLaw { period_s: 1e-3, phases_s: [0.0, 125e-6, 250e-6], off: 1, ..law(3) };
    let text = Profile::of_contacts(law).text();
    let parse = |text: &str| Profile::parse(text).map_err(|fault| fault.to_string());
    assert_eq!(parse(&text).unwrap().text(), text);
    let line = text.lines().rfind(|line| line.starts_with("points")).unwrap();
    assert!(parse(&text.replace(line, "points = [[2, 5], [40.5, 0.3]]")).is_ok());
    for (from, to, part) in [
        ("off = 2", "off = 3", "`contacts.off` is found contact 3; expected a contact above"),
        ("off = 2", "off = 0", "`contacts.off`"),
        ("[2.0, 5.0, 8.0]", "[2.0, 5.0, 4.0]", "`contacts.depths_mm` is found 4 mm"),
        ("[2.0, 5.0, 8.0]", "[2.0]", "1 depths; expected two or three"),
        ("from = 2", "from = 3", "`contacts.table.from` is 3"),
        ("from = 2", "from = 1", "1 tables; expected one for each"),
        ("[0.0, 125.0, 250.0]", "[0.0, 1250.0, 250.0]", "expected 0 to 0.1 s, a phase within the period"),
        ("[contacts]", "travel_mm = 10\n[contacts]", "contacts alone"),
        (line, "points = [[2, 5], [40.5, 5.3]]", "point 2: expected times that rise"),
        (line, "points = [[2], [40.5, 5.3]]", "[between_ms, hammer_speed_m_per_s]"),
    ] {
        let fault = parse(&text.replace(from, to)).unwrap_err();
        assert!(fault.contains(part), "{to}: {fault}");
    }
}

/// Edges as text; between two notes the sender is silent for ten seconds; a stamp goes back, and again.
#[test]
fn a_stream_of_edges_is_read() {
    let head = Head::parse("time_us,key,contact,state").unwrap();
    assert_eq!(head.quantity, SensorUnit::Contacts);
    let mut reader = Reader::new(head);
    for (line, part) in [
        ("1,40,made", "four fields"),
        ("1,40,1,made,2", "four fields"),
        ("1,40,4,made", "contact is `4`"),
        ("1,40,1,closed", "state is `closed`"),
        ("1,99,1,made", "key is `99`"),
        ("x,40,1,made", "time is `x`"),
    ] {
        let fault = reader.line(line).unwrap_err().to_string();
        assert!(fault.contains(part), "{line}: {fault}");
    }
    assert_eq!(reader.line("500000,sustain,1"), Ok(Some(Sample { time_s: 0.5, of: Of::Pedal(64), value: 1.0 })));
    let stroke = |at_us: u64| {
        [(0, 1, "made"), (10_000, 2, "made"), (100_000, 2, "open"), (115_000, 1, "open")]
            .map(|(us, contact, state)| format!("{},1,{contact},{state}", at_us + us))
    };
    let lines = [stroke(1_000_000), stroke(11_000_000), stroke(1_000_000)].concat();
    let samples: Vec<Sample> = lines.iter().map(|line| reader.line(line).unwrap().unwrap()).collect();
    let (events, report) = played(&law(2), &samples);
    assert_eq!((ons(&events).len(), offs(&events).len(), report.stream_gaps, report.new_clocks), (3, 3, 0, 1));
    assert!(ons(&events).iter().all(|[_, speed]| (speed - 1.0).abs() < 1e-9), "{events:?}");
    // A contact that the profile does not have, and a key that is not there.
    let lost = [Of::Contact(1, 2), Of::Contact(2, 0)].map(|of| Sample { time_s: 20.0, of, value: 1.0 });
    let (_, report) = played(&law(2), &lost);
    let why = report.silence.as_deref();
    let expected = "none of 2 samples is of a key or contact that the calibration has";
    assert_eq!((report.uncalibrated, report.samples, why), (2, 0, Some(expected)));
    let why = |samples: &[Sample]| played(&law(2), samples).1.silence.unwrap();
    assert!(why(&samples[..1]).contains("no key comes to its lowest contact"));
    let swapped: Vec<Sample> =
        (0..2).map(|i| Sample { time_s: 0.01 * i as f64, of: Of::Contact(1, 1 - i), value: 1.0 }).collect();
    assert!(why(&swapped).contains("close before upper ones"));
}
