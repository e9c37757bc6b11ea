//! The loop with a device: still where theory and the advice say so, and no use at 1 kHz without a coupling.

use erard::Instrument;

use crate::haptic_loop::{Device, Finger, play, play_admittance, stiffest_still};

fn grand() -> Instrument {
    Instrument::builtin("concert-grand").unwrap()
}

/// Half of what Colgate's condition allows, with the loop's delay: still at every rate, under every finger, and the
/// note sounds.
#[test]
fn passive_couplings_are_still() {
    for (rate, damping) in [(1e3, 4.0), (4e3, 2.0), (20e3, 2.0)] {
        let device = Device::usual(rate, damping);
        let coupling = 0.5 * device.passive_n_per_m(0.0, true);
        for finger in [Finger::Force(6.0), Finger::Hand] {
            let out = play(&grand(), &device, [coupling, 0.0], finger, false);
            assert!(out.is_still() && !out.saturated, "{rate} Hz, {coupling:.0} N/m, {finger:?}: {out:?}");
            assert!(out.hammer_speed_m_per_s > 0.3, "{rate} Hz, {finger:?}: {out:?}");
        }
    }
}

/// What is still in simulation lies above what is passive in theory, which answers for every finger, and below what
/// quanta allow.
#[test]
fn theory_is_on_the_safe_side() {
    let device = Device::usual(4e3, 2.0);
    let (found, passive) = (stiffest_still(&grand(), &device), device.passive_n_per_m(0.0, true));
    assert!(found > passive && passive < device.quantised_n_per_m(), "{found:.0} N/m, passive {passive:.0} N/m");
}

/// An imposed position asks for mass times its second difference: a quantum of 1 um in 50 us are 400 m/s2, a hundred
/// newtons on a quarter of a kilogram. Where the speed is not smoothed over more than a period the motor is asked for
/// more than it has: at 1 kHz.
#[test]
fn rigid_coupling_is_none() {
    let device = Device { window_s: 1e-3, ..Device::usual(1e3, 4.0) };
    let out = play(&grand(), &device, [0.0; 2], Finger::Hand, true);
    assert!(out.saturated, "{out:?}");
}

/// The way round, with a good servo at 20 kHz, the impact is that of the finger on the simulated key itself, to a
/// tenth.
#[test]
fn admittance_renders_the_impact() {
    let [direct, servo] = [20e3, 1e3].map(|bandwidth| play_admittance(&grand(), 50e-6, bandwidth, Finger::Hand));
    assert!(direct.hammer_speed_m_per_s > 0.3 && servo.is_still(), "{direct:?} {servo:?}");
    assert!((servo.hammer_speed_m_per_s / direct.hammer_speed_m_per_s - 1.0).abs() < 0.1, "{direct:?} {servo:?}");
}

/// A body that nothing moves, in place of the action.
fn wall() -> Instrument {
    Instrument::parse(
        r#"
        format = "erard-instrument/1"
        name = "Wall"
        gravity_m_s2 = 0
        finger = { stiffness_N_per_m = 2e4, damping_N_s_per_m = 1 }
        roles = { key = "wall", key_front_mm = [-1000, 0] }
        [[body]]
        name = "wall"
        pivot_mm = [0, 0]
        mass_g = 1e6
        inertia_kg_m2 = 1e6
        center_of_mass_mm = [0, 0]
        "#,
        "wall",
    )
    .unwrap()
}

/// Against a wall the loop is linear, and stands as far as the eigenvalues of its map from sample to sample lie within
/// the unit circle. The limits were worked out apart from this program (NumPy): with position, speed and motor force of
/// the device under a held command by the matrix exponential, the command told a period late, and the force K (x + v' T
/// / 2) of a coupling that is led on by the speed v' of the window.
#[test]
fn a_wall_stands_as_far_as_its_eigenvalues_say() {
    let wall = wall();
    for (rate, damping, limit) in
        [(1e3, 2.0, 1652.0), (1e3, 10.0, 8057.0), (4e3, 2.0, 4445.0), (4e3, 7.0, 15567.0), (20e3, 7.0, 28463.0)]
    {
        let device = Device { friction_n: 0.0, quantum_m: 1e-12, ..Device::usual(rate, damping) };
        let is_still = |coupling: f64| play(&wall, &device, [coupling, 0.0], Finger::Force(6.0), false).is_still();
        assert!(is_still(0.96 * limit) && !is_still(1.04 * limit), "{rate} Hz, {damping} N s/m");
        assert!(device.passive_n_per_m(0.0, true) < limit, "theory is on the safe side");
    }
}

/// Beyond the limit that the eigenvalues give, a delay t = b / limit feeds pi w (K t - b) A^2 into a cycle of amplitude
/// A, and the device's dry friction c takes 4 c A. So motions smaller than A = 4 c / (pi w (K t - b)) die away, larger
/// ones grow: whether the loop is still depends on the motion that the press leaves. A force F leaves F / K.
#[test]
fn dry_friction_holds_small_motions_only() {
    for (rate, damping, limit, coupling) in
        [(1e3, 2.0, 1652.0, 2500.0), (4e3, 2.0, 4445.0, 9e3), (4e3, 7.0, 15567.0, 22e3), (20e3, 7.0, 28463.0, 45e3)]
    {
        let device = Device { quantum_m: 1e-12, ..Device::usual(rate, damping) };
        let angular = (coupling / device.mass_kg).sqrt();
        let amplitude_m =
            4.0 * device.friction_n / (std::f64::consts::PI * angular * (coupling * damping / limit - damping));
        let is_still = |part: f64| {
            let force = Finger::Force(part * amplitude_m * coupling);
            play(&wall(), &device, [coupling, 0.0], force, false).is_still()
        };
        assert!(is_still(0.9) && !is_still(1.2), "{rate} Hz, {damping} N s/m: {:.1} um", 1e6 * amplitude_m);
    }
}

/// A stiffer coupling may be still again, so the stiffest is sought from below. On felts without dry loss the key moves
/// with the device under a stiff coupling, and the action takes energy that a softer one leaves to the device alone.
#[test]
fn a_stiffer_coupling_can_be_still_again() {
    let grand = Instrument::builtin("concert-grand-rigid").unwrap();
    let device = Device::usual(4e3, 0.25);
    let found = stiffest_still(&grand, &device);
    let is_still = |coupling: f64| play(&grand, &device, [coupling, 0.0], Finger::Force(6.0), false).is_still();
    assert!(found < 2000.0 && !is_still(2000.0) && is_still(10e3), "{found:.0} N/m");
}
