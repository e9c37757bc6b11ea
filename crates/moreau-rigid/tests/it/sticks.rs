//! What friction can hold stays where it is over ten seconds, and what it cannot hold falls as it should.

// The example prints its table; the test reads its functions.
#[path = "../../examples/sticks.rs"]
#[allow(dead_code)]
mod example;

use example::{BETWEEN_S, PUSH_N, SLOPE_DEG, block_m, pinched_m};

/// Rounding of the plane's normal and of positions, m.
const ROUNDING_M: f64 = 1e-14;

#[test]
fn a_block_on_a_slope_and_a_pinched_cylinder_stay() {
    for h in [2e-3, 5e-4] {
        assert!(block_m(SLOPE_DEG, h, BETWEEN_S).unwrap() < ROUNDING_M, "block, {h}");
        assert!(pinched_m(PUSH_N, h, BETWEEN_S).unwrap() < ROUNDING_M, "cylinder, {h}");
    }
}

/// From rest, with the acceleration a, a body goes a (1^2 - 0.1^2) / 2 m between 0.1 s and 1 s; the implicit step adds
/// half a step's way, a h (1 - 0.1) / 2, at most.
#[test]
fn beyond_their_friction_both_slide() {
    let (g, h, between_s) = (9.81, 2e-3, [0.1, 1.0]);
    let falls = |a: f64| 0.5 * a * 0.99;
    let slope = 30_f64.to_radians();
    let a = g * (slope.sin() - 0.5 * slope.cos());
    let block = block_m(30.0, h, between_s).unwrap();
    assert!((block - falls(a)).abs() <= 0.46 * a * h, "{block} for {}", falls(a));
    // 0.8 N carry 0.8 N of 0.981 N; the forces on both sides turn it neither way.
    let a = g - 0.8 / 0.1;
    let pinched = pinched_m(0.8, h, between_s).unwrap();
    assert!((pinched - falls(a)).abs() <= 0.46 * a * h, "{pinched} for {}", falls(a));
}
