//! A mass of 10 g thrown at a felt at 1 m/s.

use moreau::{Body, Curve, Exponent, Felt, GROUND, Ledger, Model, Pose, Settings, Zone};

use crate::mechanism::{Mechanism, order};

/// A mass at the end of an arm so long that its path is straight: x = L sin(angle), L = 100 m, so that over the felt's 1 mm
/// of compression the arm turns by 1e-5 rad and the path deviates from a line by 1e-10 of itself.
const ARM: f64 = 100.0;
const MASS: f64 = 0.010;

struct Throw {
    compression: f64,
    contact_time: f64,
    rebound: f64,
    residual: f64,
}

fn throw(k: f64, r: f64, b: f64, h: f64) -> Throw {
    let body = Body { mass: MASS, center_of_mass: [0.0, -ARM], inertia: MASS * ARM * ARM, ..Body::inert() };
    let felt = Felt { stiffness: k, exponent: Exponent::new(r), damping: b };
    // The mass starts a whole number of steps away, plus a third: a generic phase.
    let start = 20.0 * h + h / 3.0;
    let zone = Zone {
        disc_body: 0,
        center: [0.0, -ARM],
        radius: 0.0,
        curve_body: GROUND,
        curve: Curve::Line { point: [start, 0.0], normal: [-1.0, 0.0] },
        felt,
        friction: None,
    };
    let model = Model::<f64, 1, 1>::new(&[body], &[], &[zone], None, 0.0).unwrap();
    let settings = Settings { tolerance: 1e-12, ..Settings::new(h) };
    let mut m = Mechanism::<1, 1, 1>::new(model, [0.0], [1.0 / ARM], settings);
    let mut ledger = Ledger::open(&m.model, &m.state);
    let mut compression: f64 = 0.0;
    let (mut touch, mut part) = (None, None);
    let mut gap = Pose::of(&m.model, &m.state.angle).gap(&m.model, 0);
    for _ in 0..(6e-3 / h) as usize {
        let before = m.state.clone();
        m.step();
        ledger.record(&m.model, &m.settings, &before, &m.state, &m.scratch);
        let next = Pose::of(&m.model, &m.state.angle).gap(&m.model, 0);
        // Instants by linear interpolation of the gap; largest compression by the parabola through its velocity's zero.
        if gap <= 0.0 && next > 0.0 {
            touch = Some(m.time - h * next / (next - gap));
        }
        if gap > 0.0 && next <= 0.0 {
            part = Some(m.time - h * next / (next - gap));
        }
        let (v0, v1) = (before.velocity[0] * ARM, m.state.velocity[0] * ARM);
        if v0 > 0.0 && v1 <= 0.0 {
            compression = gap + v0 * v0 * h / (2.0 * (v0 - v1));
        }
        gap = next;
    }
    ledger.take_stock(&m.model, &m.state);
    Throw {
        compression,
        contact_time: part.unwrap() - touch.unwrap(),
        rebound: -m.state.velocity[0] * ARM,
        residual: ledger.residual_relative(),
    }
}

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// Problem 5: closed forms for b = 0. Second order: errors at h = 1 us (1/1700 of the contact) are a few times 1e-7.
#[test]
fn elastic_felt() {
    for (r, k, compression, contact) in [
        (2.0, 5e7, 6.694_329_500_8e-4, 1.877_333_806_6e-3),
        (2.5, 3e9, 6.169_670_082_2e-4, 1.666_704_945_2e-3),
        (3.0, 1e11, 6.687_403_049_8e-4, 1.753_475_568_5e-3),
    ] {
        let t = throw(k, r, 0.0, 1e-6);
        assert!(relative(t.compression, compression) < 2e-6, "r {r}: compression {}", t.compression);
        assert!(relative(t.contact_time, contact) < 2e-6, "r {r}: contact {}", t.contact_time);
        assert!(relative(t.rebound, 1.0) < 2e-6, "r {r}: rebound {}", t.rebound);
        assert!(t.residual < 2e-6, "r {r}: energy {}", t.residual);
    }
}

/// Problem 6: damped felt, the force clamped at zero. (The unclamped law of the papers pulls before separation when r > 2 and
/// would give 0.43121981 and 0.53364008.)
#[test]
fn damped_felt() {
    for (r, k, b, rebound, compression) in [
        (2.0, 5e7, 3e7, 0.711_950_179_6, 6.006_110_607_3e-4),
        (2.5, 3e9, 1e8, 0.435_620_80, 4.993_564_099e-4),
        (3.0, 1e11, 5e7, 0.541_844_41, 5.807_980_575e-4),
    ] {
        let t = throw(k, r, b, 1e-6);
        assert!(relative(t.rebound, rebound) < 3e-6, "r {r}: rebound {}", t.rebound);
        assert!(relative(t.compression, compression) < 3e-6, "r {r}: compression {}", t.compression);
        assert!(t.residual < 3e-6, "r {r}: energy {}", t.residual);
    }
}

/// The error of the rebound falls with the square of the step, across both ends of the contact (the felt's law is smooth
/// enough there: its force starts as g^2).
#[test]
fn damped_felt_is_of_second_order() {
    let errors: Vec<f64> =
        (0..4).map(|k| (throw(5e7, 2.0, 3e7, 3.2e-5 / f64::from(1 << k)).rebound - 0.711_950_179_6).abs()).collect();
    assert!((order(&errors) - 2.0).abs() < 0.3, "{errors:?}");
}
