//! Laws against published points, both ways, and tables that are refused.

use erard_midi::{Law, LawError, ReleaseLaw, Velocity};

/// The points that Goebl's thesis gives beside its equation, and the number of bits that tells them.
#[test]
fn the_published_law_has_its_published_points() {
    for (counts, speed) in [(40.0, 0.72), (60.0, 1.25), (77.0, 2.0), (110.0, 5.0), (127.0, 8.0)] {
        assert!((Law::GOEBL.speed_m_per_s(Velocity::new(counts)) / speed - 1.0).abs() < 5e-3, "{counts}");
        let found = Law::GOEBL.velocity(speed).counts();
        assert!((found - counts).abs() < 0.2, "{speed} m/s: {found}");
    }
    // One count is 2.8 % of the speed.
    let ratio = Law::GOEBL.speed_m_per_s(Velocity::new(65.0)) / Law::GOEBL.speed_m_per_s(Velocity::new(64.0));
    assert!((ratio - 1.0281).abs() < 1e-4, "{ratio}");
}

#[test]
fn every_law_goes_both_ways_and_rises() {
    let points = [[0.2, 1.0], [0.5, 30.0], [2.0, 80.0], [6.0, 127.0]];
    let laws = [Law::GOEBL, Law::Linear { full_m_per_s: 7.0 }, Law::table(&points).unwrap()];
    for law in laws {
        let mut before = -1.0;
        for n in 1..=1000 {
            let counts = 0.127 * f64::from(n);
            let speed = law.speed_m_per_s(Velocity::new(counts));
            assert!(speed > before, "{law:?} at {counts}");
            before = speed;
            let back = law.velocity(speed).counts();
            assert!((back - counts).abs() < 1e-9, "{law:?}: {back} for {counts}");
        }
        for none in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(law.velocity(none).counts(), 0.0, "{law:?} of {none}");
        }
        assert_eq!(law.velocity(f64::INFINITY).counts(), 127.0, "{law:?}");
    }
    for [speed, counts] in points {
        assert!((laws[2].velocity(speed).counts() - counts).abs() < 1e-9);
    }
}

#[test]
fn a_table_that_is_none_is_refused() {
    assert_eq!(Law::table(&[[1.0, 60.0]]), Err(LawError::TooFew));
    assert_eq!(Law::table(&[[1.0, 60.0], [2.0, 128.0]]), Err(LawError::OutOfRange(1)));
    assert_eq!(Law::table(&[[0.0, 60.0], [2.0, 80.0]]), Err(LawError::OutOfRange(0)));
    assert_eq!(Law::table(&[[f64::NAN, 60.0], [2.0, 80.0]]), Err(LawError::OutOfRange(0)));
    assert_eq!(Law::table(&[[1.0, 60.0], [2.0, 60.0]]), Err(LawError::NotAscending(1)));
    assert_eq!(Law::table(&[[1.0, 60.0], [1.0, 70.0]]), Err(LawError::NotAscending(1)));
}

#[test]
fn releases_go_both_ways() {
    for counts in [1.0, 40.0, 64.0, 127.0] {
        let speed = ReleaseLaw::USUAL.speed_m_per_s(Velocity::new(counts));
        assert!((ReleaseLaw::USUAL.velocity(speed).counts() - counts).abs() < 1e-12);
    }
    assert_eq!(ReleaseLaw::USUAL.velocity(-0.1).counts(), 0.0);
}
