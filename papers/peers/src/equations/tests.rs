use super::*;
use crate::mechanism::{Blow, Body, Disc, Felt, Finger, Hold, Spring, Strike};
use crate::number::Dual;

const B: usize = 6;
const S: usize = 12;

/// A chain of three and three single bodies, with every kind of curve; not a piano, so that no terms cancel by chance.
fn mechanism() -> Mechanism {
    let body = |parent, x: f64, dry_friction| Body {
        parent,
        pivot_m: [0.1 + x, 0.2 - x],
        mass_kg: 0.3 + x,
        inertia_kg_m2: 0.02 + 0.01 * x,
        center_of_mass_m: [0.1, -0.05 + 0.1 * x],
        dry_friction,
        viscous_friction: 0.1 * dry_friction,
        rest_angle_rad: 0.0,
    };
    let zone = |disc, curve_body, curve, exponent, damping, friction_coefficient| Zone {
        disc: Disc { body: disc, center_m: [0.2, 0.1], radius_m: 2.0 },
        curve_body,
        curve,
        felt: Felt { stiffness: 3.0, exponent, damping },
        friction_coefficient,
    };
    let line = Curve::Line { point_m: [0.1, 0.3], normal: [0.6, 0.8] };
    let segment = Curve::Segment { from_m: [0.0, 0.1], to_m: [0.4, 0.2], rounding_m: 0.1 };
    let disc = Curve::Disc { center_m: [0.3, -0.1], radius_m: 0.2 };
    Mechanism {
        format: String::new(),
        gravity_m_s2: 9.81,
        bodies: vec![
            body(None, 0.0, 0.3),
            body(Some(0), 0.3, 0.2),
            body(Some(1), 0.1, 0.1),
            body(Some(0), 0.2, 0.3),
            body(None, 0.5, 0.2),
            body(None, 0.4, 0.1),
        ],
        springs: vec![Spring { body: 2, torque: 0.3, stiffness: 1.0, reference_rad: 0.2 }],
        zones: vec![
            zone(Some(2), Some(3), line, 2.0, 1.0, 0.4),
            zone(Some(4), Some(2), segment, 2.5, 1.0, 0.3),
            zone(Some(5), None, disc, 3.0, 1.0, 0.2),
            zone(None, Some(3), Curve::Line { point_m: [0.0, 0.0], normal: [0.0, 1.0] }, 1.7, 1.0, 0.2),
        ],
        finger: Finger { body: 1, point_m: [0.1, 0.1], direction: [0.0, -1.0] },
        strike: Strike { body: 2, point_m: [0.1, 0.2], direction: [0.0, 1.0], meets_m: 0.5 },
        blow: Blow {
            until_s: 1.0,
            scales: vec![1.0],
            times_s: vec![0.0, 1.0, 3.0],
            forces: vec![1.0, 2.0, 0.0],
            slopes: vec![0.5, -1.0, 0.0],
        },
        hold: Hold { force: 1.0, from_s: 0.0, until_s: 1.0 },
    }
}

const WIDTHS: Widths = Widths { pivot: 0.3, sliding: 0.2 };

fn states() -> impl Iterator<Item = [f64; S]> {
    (0..40).map(|n| std::array::from_fn(|i| ((1 + n * S + i) as f64 * 2.399).sin() * 1.5))
}

/// Kinetic energy from point velocities, plus the potential energy of gravity, springs and felts.
fn energy<T: Number>(mechanism: &Mechanism, y: &[T; S]) -> T {
    let pose = Pose::<T, B>::of(mechanism, y);
    let mut sum = T::constant(0.0);
    for (i, b) in mechanism.bodies.iter().enumerate() {
        let at = pose.point(Some(i), b.center_of_mass_m);
        let v = pose.velocity(Some(i), at);
        let [gx, gy] = b.center_of_mass_m;
        let about_center = b.inertia_kg_m2 - b.mass_kg * (gx * gx + gy * gy);
        sum += dot(v, v).times(0.5 * b.mass_kg) + (pose.rate[i] * pose.rate[i]).times(0.5 * about_center);
        sum += at[1].times(b.mass_kg * mechanism.gravity_m_s2);
    }
    for s in &mechanism.springs {
        let parent = mechanism.bodies[s.body].parent;
        let turn = y[s.body] - parent.map_or(T::constant(0.0), |p| y[p]) - T::constant(s.reference_rad);
        sum += (turn * turn).times(0.5 * s.stiffness) - turn.times(s.torque);
    }
    for z in &mechanism.zones {
        let compression = T::constant(z.disc.radius_m) - Equations::<B, S>::distance(z, &pose).0;
        if compression.value() > 0.0 {
            let r = z.felt.exponent + 1.0;
            sum += compression.powf(r).times(z.felt.stiffness / r);
        }
    }
    sum
}

/// dE/dt along the motion; the energy is differentiated, not the forces.
fn power(mechanism: &Mechanism, y: &[f64; S], force: f64) -> f64 {
    let rates = Equations::<B, S>::new(mechanism, WIDTHS).rates(force, y);
    energy(mechanism, &std::array::from_fn(|i| Dual { value: y[i], slope: rates[i] })).slope
}

/// Without losses only the finger changes the energy, with a power of force times velocity. Rounding of terms of order
/// 10.
#[test]
fn power_is_what_the_finger_gives() {
    let mut mechanism = mechanism();
    for b in &mut mechanism.bodies {
        (b.dry_friction, b.viscous_friction) = (0.0, 0.0);
    }
    for z in &mut mechanism.zones {
        (z.felt.damping, z.friction_coefficient) = (0.0, 0.0);
    }
    for y in states() {
        let pose = Pose::<f64, B>::of(&mechanism, &y);
        let at = pose.point(Some(1), mechanism.finger.point_m);
        let given = -2.0 * pose.velocity(Some(1), at)[1];
        let found = power(&mechanism, &y, 2.0);
        assert!((found - given).abs() < 1e-10, "{found} {given}");
    }
}

/// Every kind of loss takes energy. (A felt's damping is left out: unclamped it returns energy when the felt opens.)
#[test]
fn friction_takes_energy() {
    for (dry, viscous, sliding) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)] {
        let mut mechanism = mechanism();
        for b in &mut mechanism.bodies {
            b.dry_friction *= dry;
            b.viscous_friction *= viscous;
        }
        for z in &mut mechanism.zones {
            z.friction_coefficient *= sliding;
            z.felt.damping = 0.0;
        }
        let losses: Vec<f64> = states().map(|y| power(&mechanism, &y, 0.0)).collect();
        assert!(losses.iter().all(|&p| p < 1e-10), "{losses:?}");
        assert!(losses.iter().any(|&p| p < -1e-3), "{losses:?}");
    }
}

/// The carried derivative against central differences of step 1e-6 (error near 1e-8 at these numbers).
#[test]
fn derivatives_are_derivatives() {
    let mechanism = mechanism();
    let equations = Equations::<B, S>::new(&mechanism, WIDTHS);
    for y in states() {
        let direction: [f64; S] = std::array::from_fn(|i| ((i * i + 3) as f64).sin());
        let carried = equations.rates(1.0, &std::array::from_fn(|i| Dual { value: y[i], slope: direction[i] }));
        let at = |e: f64| equations.rates(1.0, &std::array::from_fn(|i| y[i] + e * direction[i]));
        let (up, down) = (at(1e-6), at(-1e-6));
        for i in 0..S {
            let difference = (up[i] - down[i]) / 2e-6;
            assert!((difference - carried[i].slope).abs() < 1e-6 * (1.0 + difference.abs()), "{i}");
        }
    }
}

/// A cubic piece meets its samples and slopes.
#[test]
fn force_pieces() {
    let blow = mechanism().blow;
    for (t, force, slope) in [(0.0, 1.0, 0.5), (1.0, 2.0, -1.0), (3.0, 0.0, 0.0)] {
        assert!((blow.force(t) - force).abs() < 1e-12);
        let inside: f64 = if t > 0.0 { -1e-7 } else { 1e-7 };
        assert!(((blow.force(t + inside) - blow.force(t)) / inside - slope).abs() < 1e-5);
    }
    assert_eq!((blow.force(-1.0), blow.force(9.0)), (1.0, 0.0));
}

/// The strike point's speed equals the rate of its coordinate toward the string, projected on that direction.
#[test]
fn the_strike_point_moves_as_its_speed_says() {
    let mut mechanism = mechanism();
    for y in states() {
        let along = |direction: [f64; 2], mechanism: &mut Mechanism| {
            mechanism.strike.direction = direction;
            let equations = Equations::<B, S>::new(mechanism, WIDTHS);
            let at = |t: f64| {
                equations.beyond_string(&std::array::from_fn(|i| if i < B { y[i] + t * y[B + i] } else { y[i] }))
            };
            (at(1e-6) - at(-1e-6)) / 2e-6
        };
        let [x, up] = [[1.0, 0.0], [0.0, 1.0]].map(|direction| along(direction, &mut mechanism));
        let speed = Equations::<B, S>::new(&mechanism, WIDTHS).hammer_speed(&y);
        assert!((x.hypot(up) - speed).abs() < 1e-7 * (1.0 + speed), "{} {speed}", x.hypot(up));
    }
}
