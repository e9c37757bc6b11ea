//! Readings to millimetres.

use std::collections::BTreeMap;
use std::path::Path;

use erard_live::calibrate::{Readings, StopsFault, stops};
use erard_live::profile::{Profile, Sensed, Stops};
use erard_live::sensor::{CNY70, Law, LawFault};

/// Columns of a recording of the Kawai KG-3C beside this crate: times, and the key's as read or in mm.
fn recording(name: &str, stroke: Option<&str>) -> Vec<[f64; 2]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../erard-core/recordings").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|one| *one == name);
    let key = at("key").or(at("key_mm")).unwrap();
    let (time, own) = (at("time_s").unwrap(), at("stroke"));
    lines
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|row| own.is_none_or(|own| stroke == Some(row[own])))
        .map(|row| [row[time].parse().unwrap(), row[key].parse().unwrap()])
        .collect()
}

/// A key of a Kawai, read by a CNY-70: the slow press tells its stops, and the other presses come out as they were
/// calibrated with a ruler (`recordings/calibrate.py`), wherever the sensor sees anything.
#[test]
fn a_measured_key_comes_out_in_millimetres() {
    let slow = recording("kawai-kg-3c-raw.csv", Some("slow"));
    let found = stops(&BTreeMap::from([(44, Readings { all: slow })])).unwrap()[&44];
    println!("{found:?}");
    // Up 0.3, as the ruler's table says; down 0.86 to 0.88.
    assert!((found.stops.rest - 0.301).abs() < 0.003, "{found:?}");
    assert!((0.83..0.9).contains(&found.stops.pressed), "{found:?}");
    // The stops of the ruler's table, 0.3 and 0.88; the reading at rest is 0.0017 of that range above the first. The
    // smooth curve through the marks ends at 11.67 mm.
    let ruler = Profile {
        sensed: Sensed::Keys,
        law: Law::Cny70 {},
        travel_m: 11.67e-3,
        pressure_is_depth: false,
        keys: BTreeMap::from([(44, Stops { rest: 0.3 + 0.0017 * 0.58, pressed: 0.88 })]),
    };
    let mut worst_mm: f64 = 0.0;
    for stroke in ["slow", "medium", "fast"] {
        let (raw, mm) =
            (recording("kawai-kg-3c-raw.csv", Some(stroke)), recording(&format!("kawai-kg-3c-{stroke}.csv"), None));
        let mut converter = ruler.converter(44).unwrap();
        for ([t, read], [_, truth]) in raw.iter().zip(&mm) {
            let own = 1e3 * converter.travel_m(*t, *read);
            if *truth > 3.0 && (own - truth).abs() > worst_mm {
                worst_mm = worst_mm.max((own - truth).abs());
            }
        }
        assert!(mm.len() > 100, "{stroke}");
    }
    // Straight lines between fifteen points beside the smooth curve.
    println!("{worst_mm:.3} mm");
    assert!(worst_mm < 0.15, "{worst_mm}");
}

/// The same readings with a drift that grows to a tenth of the range: the rest follows it, and the bottom with it.
#[test]
fn drift_is_followed() {
    let profile = Profile {
        sensed: Sensed::Keys,
        law: Law::Linear {},
        travel_m: 0.01,
        pressure_is_depth: false,
        keys: BTreeMap::from([(1, Stops { rest: 3000.0, pressed: 1000.0 })]),
    };
    let mut converter = profile.converter(1).unwrap();
    let (mut at_rest, mut at_bottom) = (0.0_f64, 0.0_f64);
    for k in 0..200_000_u32 {
        let t = f64::from(k) * 1e-3;
        // Five seconds at rest, half a second down.
        let is_down = t % 5.5 > 5.0;
        let drifts = -200.0 * t / 200.0;
        let own = converter.travel_m(t, if is_down { 1000.0 } else { 3000.0 } + drifts);
        if t > 10.0 {
            if is_down { at_bottom = at_bottom.max((own - 0.01).abs()) } else { at_rest = at_rest.max(own.abs()) }
        }
    }
    assert!(at_rest < 0.1e-3 && at_bottom < 0.1e-3, "{at_rest} {at_bottom}");
    assert!((converter.drift() - 0.1).abs() < 0.01 && converter.beyond() == 0, "{}", converter.drift());
    (200_000..400_000_u32).for_each(|k| {
        converter.travel_m(f64::from(k) * 1e-3, 3000.0 - f64::from(k) * 1e-3);
    });
    assert!(converter.beyond() == 1 && converter.drift() <= 0.15, "{converter:?}");
}

/// Laws are exact at both stops, rise, and a dipole's field gives back its distance.
#[test]
fn laws_rise_from_stop_to_stop() {
    let table = Law::Table { points: vec![[0.0, 0.0], [0.3, 0.6], [1.0, 1.0]] };
    let halls = [false, true].map(|at_rest| Law::Hall { nearest_mm: 3.0, at_rest });
    for law in [Law::Linear {}, Law::Cny70 {}, table, halls[0].clone(), halls[1].clone()] {
        law.check().unwrap();
        let share = |read: f64| law.share(read, 0.01);
        assert!(share(0.0).abs() < 1e-12 && (share(1.0) - 1.0).abs() < 1e-12, "{law:?}");
        assert!((0..100).all(|k| share(f64::from(k + 1) / 100.0) > share(f64::from(k) / 100.0)), "{law:?}");
    }
    // 3 mm away when pressed, 13 at rest; the reading in units of the field.
    let field = |mm: f64| 1.0 / mm.powi(3);
    for x in [0.1, 2.0, 5.0, 9.0] {
        let read = (field(13.0 - x) - field(13.0)) / (field(3.0) - field(13.0));
        assert!((10.0 * halls[0].share(read, 0.01) - x).abs() < 1e-9, "{x}");
        let read = (field(3.0 + x) - field(3.0)) / (field(13.0) - field(3.0));
        assert!((10.0 * halls[1].share(read, 0.01) - x).abs() < 1e-9, "{x}");
    }
    assert!((Law::Cny70 {}.share(CNY70[10], 0.012) - 10.0 / 15.0).abs() < 1e-12);
    assert!(Law::Table { points: vec![[0.0, 0.0], [0.5, 0.5], [0.4, 1.0]] }.check().is_err());
    assert!(Law::Hall { nearest_mm: f64::NAN, at_rest: true }.check().is_err());
}

/// What is written reads back; faults name their place.
#[test]
fn profiles_are_written_and_read() {
    let profile = Profile {
        sensed: Sensed::Keys,
        law: Law::Table { points: vec![[0.0, 0.0], [0.25, 0.5], [1.0, 1.0]] },
        travel_m: 9.7e-3,
        pressure_is_depth: true,
        keys: BTreeMap::from([(40, Stops { rest: 3120.5, pressed: 811.25 }), (41, Stops { rest: 0.1, pressed: 0.9 })]),
    };
    assert_eq!(Profile::parse(&profile.text()).unwrap(), profile);
    for (from, to, part) in [
        ("erard-sensors/1", "erard-sensors/2", "`format` is \"erard-sensors/2\""),
        ("9.7", "0.1", "`travel_mm` is 0.1"),
        ("number = 41", "number = 40", "each once"),
        ("rest = 0.1", "rest = 0.9", "two different"),
        ("kind = \"table\"", "kind = \"tabel\"", "line"),
        ("[1.0, 1.0]", "[1.0, 2.0]", "point 3"),
        ("[[key]]", "[[keys]]", "line"),
    ] {
        let fault = Profile::parse(&profile.text().replace(from, to)).unwrap_err().to_string();
        assert!(fault.contains(part), "{to}: {fault}");
    }
}

#[test]
fn readings_without_stops_are_refused() {
    let fault = |at: &dyn Fn(f64) -> f64| {
        let all = (0..3000_u32).map(|k| f64::from(k) * 1e-3).map(|t| [t, at(t)]).collect();
        stops(&BTreeMap::from([(5, Readings { all })])).unwrap_err()
    };
    assert_eq!(fault(&|_| 7.0), StopsFault::Stuck { key: 5, found: 7.0 });
    let mut random = fastrand::Rng::with_seed(1);
    let noise: Vec<f64> = (0..3000).map(|_| random.f64()).collect();
    assert!(matches!(fault(&|t| noise[(1e3 * t + 0.5) as usize]), StopsFault::Noise { .. }));
    assert!(matches!(fault(&|t| if t < 0.5 { 0.0 } else { 100.0 * t }), StopsFault::NotHeld { .. }));
    let few = stops(&BTreeMap::from([(5, Readings { all: vec![[0.0, 1.0]; 3] })])).unwrap_err();
    assert!(matches!(few, StopsFault::Few { found: 3, .. }));
}

/// A ruler's table as it is read: a flat start, noise, falling readings. The law is monotone, exact at both stops, and
/// nearest to the readings; what cannot be a law is named.
#[test]
fn a_rulers_table_is_made_monotone() {
    // Nothing is seen up to 2 mm; then 100 a millimetre, and two readings in the wrong order.
    let readings = [500.0, 500.0, 500.0, 600.0, 740.0, 660.0, 800.0, 900.0];
    for sign in [1.0, -1.0] {
        let points: Vec<[f64; 2]> = readings.iter().enumerate().map(|(i, r)| [sign * r, 1.0 + i as f64]).collect();
        let (law, averaged, changed) = Law::of_points(&points).unwrap();
        law.check().unwrap();
        // Three of the start, and two that are 700 at 5.5 mm.
        assert_eq!((averaged, changed), (5, 40.0), "{law:?}");
        let at = |reading: f64| 1.0 + 7.0 * law.share((reading - 500.0) / 400.0, 0.007);
        for (reading, mm) in [(500.0, 1.0), (600.0, 4.0), (700.0, 5.5), (800.0, 7.0), (900.0, 8.0)] {
            assert!((at(reading) - mm).abs() < 1e-12, "{reading}: {}", at(reading));
        }
    }
    let fault = |points: &[[f64; 2]]| Law::of_points(points).unwrap_err();
    assert_eq!(fault(&[[1.0, 0.0], [2.0, 3.0], [3.0, 2.0]]), LawFault::Travel { index: 2 });
    assert_eq!(fault(&[[1.0, 0.0], [f64::NAN, 3.0]]), LawFault::Travel { index: 1 });
    assert_eq!(fault(&[[7.0, 0.0], [7.0, 1.0], [7.0, 2.0]]), LawFault::Flat);
    assert_eq!(fault(&[[7.0, 0.0]]), LawFault::TooFew(1));
}
