//! Dampers over the keyboard: how soon a string is silent beside the equation of a string with a dashpot on it, levers
//! that hang alike, and a pedal that can be pressed half-way.

use std::f64::consts::PI;

use crate::common::with_rigid_bridge;
use erard::instrument::{Instrument, PianoString};
use erard::keyboard::Keyboard;
use erard::{Action, Input};

/// A key whose bridge stands still: what its strings do by themselves and under their dampers.
fn key(number: usize) -> Instrument {
    with_rigid_bridge(Keyboard::builtin("concert-grand-strings").unwrap().key(number).unwrap())
}

/// A complex number.
#[derive(Debug, Clone, Copy)]
struct Complex([f64; 2]);

impl Complex {
    fn times(self, Complex([c, d]): Complex) -> Complex {
        let Complex([a, b]) = self;
        Complex([a * c - b * d, a * d + b * c])
    }

    fn over(self, other: Complex) -> Complex {
        let Complex([c, d]) = other;
        let Complex([a, b]) = self.times(Complex([c, -d]));
        Complex([a / (c * c + d * d), b / (c * c + d * d)])
    }

    fn plus(self, Complex([c, d]): Complex) -> Complex {
        Complex([self.0[0] + c, self.0[1] + d])
    }

    fn scaled(self, by: f64) -> Complex {
        Complex(self.0.map(|x| by * x))
    }

    fn sin(self) -> Complex {
        let Complex([a, b]) = self;
        Complex([a.sin() * b.cosh(), a.cos() * b.sinh()])
    }
}

/// The decay of the first partial of an ideal string with a spring and a dashpot at a place, 1/s: the root of
/// T k sin(k L) + (i w c + s) sin(k a) sin(k (L - a)) = 0 with w = k sqrt(T/mu), followed from the free string on.
fn of_the_equation(string: &PianoString, place_m: f64, spring_n_per_m: f64, dashpot: f64) -> f64 {
    let (tension, length, speed) =
        (string.tension_n, string.length_m, (string.tension_n / string.mass_kg_per_m).sqrt());
    let left = |k: Complex, share: f64| {
        let free = k.scaled(tension).times(k.scaled(length).sin());
        let load = Complex([0.0, dashpot * speed]).times(k).plus(Complex([spring_n_per_m, 0.0])).scaled(share);
        free.plus(load.times(k.scaled(place_m).sin()).times(k.scaled(length - place_m).sin()))
    };
    let mut k = Complex([PI / length, 0.0]);
    for part in 1..=100 {
        for _ in 0..20 {
            let (share, by) = (f64::from(part) / 100.0, 1e-7 * k.0[0]);
            let slope = left(k.plus(Complex([by, 0.0])), share).plus(left(k, share).scaled(-1.0)).scaled(1.0 / by);
            k = k.plus(left(k, share).over(slope).scaled(-1.0));
        }
    }
    k.0[1] * speed
}

/// How fast the first partial falls, 1/s, so soft that the pivot's friction holds the lever still.
fn first_partial_falls(instrument: &Instrument) -> f64 {
    let mut action = Action::new(instrument).unwrap();
    let m = action.mechanism_mut();
    crate::dampers::swing(m, &[1e-4]);
    let step_s = instrument.usual_step_s();
    let period = (1.0 / instrument.strings[0].partial_hz(1) / step_s).round() as usize;
    let mut squares = |periods: usize| -> f64 {
        (0..periods * period)
            .map(|_| {
                action.step(Input::Free);
                let [_, v] = action.strings().unwrap().partial(0, 1).unwrap();
                v * v
            })
            .sum()
    };
    let (first, second) = (squares(4), squares(4));
    0.5 * (first / second).ln() / (4.0 * period as f64 * step_s)
}

/// The felt on the first string: spring at its compression, N/m, and dashpot, N s/m.
fn felt(instrument: &Instrument) -> [f64; 2] {
    let action = Action::new(instrument).unwrap();
    let force_n = action.strings().unwrap().damper_n().next().unwrap();
    let law = &instrument.zones[instrument.strings[0].damper.unwrap().zone].felt;
    let g = (force_n / law.stiffness).powf(1.0 / law.exponent);
    [law.exponent * force_n / g, law.loss.viscous(g, force_n)]
}

fn silenced(keys: &[usize]) {
    for &number in keys {
        let instrument = key(number);
        let string = &instrument.strings[0];
        let ([spring_n_per_m, dashpot], place_m) = (felt(&instrument), string.damper.unwrap().middle_m);
        let exact = of_the_equation(string, place_m, spring_n_per_m, dashpot) + string.decay_per_s(1);
        let found = first_partial_falls(&instrument);
        let impedance = (string.tension_n * string.mass_kg_per_m).sqrt();
        let t60_s = 3.0 * std::f64::consts::LN_10 / found;
        println!(
            "key {number}: dashpot {dashpot:.2} N s/m, {:.2} of Z; falls by {found:.2} /s, equation {exact:.2}; T60 {t60_s:.2} s",
            dashpot / impedance
        );
        assert!((found / exact - 1.0).abs() < 0.1, "key {number}: {found} {exact}");
        // A string of the bass is silent within a second and a half; nothing is held still.
        assert!(t60_s < 1.5 && (0.3..1.2).contains(&(dashpot / impedance)), "key {number}: {t60_s} {dashpot}");
    }
}

#[test]
fn first_partials_fall_as_a_string_with_a_dashpot_does() {
    silenced(&[1, 9, 20, 40]);
}

#[test]
#[ignore = "ci: every third key"]
fn first_partials_of_all_registers_fall_as_a_string_with_a_dashpot_does() {
    silenced(&(1..=60).step_by(3).collect::<Vec<_>>());
}

/// Dampers are set on their wires so that every lever hangs as the instrument's does, and so starts at the same dip.
#[test]
fn levers_hang_alike() {
    let hangs = |number: usize| {
        let instrument = key(number);
        let lever = instrument.bodies.iter().position(|body| body.name == "damper").unwrap();
        let action = Action::new(&instrument).unwrap();
        45.0 * (action.angles()[lever] - instrument.bodies[lever].angle_rad)
    };
    let own = hangs(40);
    for number in [1, 5, 8, 9, 14, 20, 21, 30, 47, 55, 62, 68] {
        let other = hangs(number);
        println!("key {number}: {:+.3} mm beside the instrument's", other - own);
        assert!((other - own).abs() < 0.06, "key {number}: {other} {own}");
    }
}

/// The pedal's rail has a third of a millimetre and more between a string that is damped and one that rings, in which
/// every tenth of a millimetre rings longer.
#[test]
fn the_pedal_can_be_pressed_half_way() {
    let instrument = key(40);
    let mut action = Action::new(&instrument).unwrap();
    action.set_pedal(7e-3);
    for _ in 0..6000 {
        action.step(Input::Force(5.0));
    }
    for _ in 0..2400 {
        action.step(Input::Free);
    }
    let sounding = action.save();
    let rad_per_s = std::f64::consts::TAU * instrument.strings[0].partial_hz(1);
    // Over 0.2 s, the first 50 ms after the rail has gone left out: the note's own 0.5 /s among it.
    let mut falls = |lift_m: f64| {
        action.restore(&sounding).unwrap();
        action.set_pedal(lift_m);
        let mut squares = |steps: usize| -> f64 {
            (0..steps)
                .map(|_| {
                    action.step(Input::Free);
                    // Energy: a square of the velocity alone depends on the phase at which a window ends.
                    let [q, v] = action.strings().unwrap().partial(0, 1).unwrap();
                    v * v + (rad_per_s * q).powi(2)
                })
                .sum()
        };
        squares(1200);
        let (first, second) = (squares(480), squares(480));
        let per_s = 0.5 * (first / second).ln() / 20e-3;
        println!("rail {:.1} mm: falls by {per_s:.2} /s", 1e3 * lift_m);
        per_s
    };
    let found = [0.0, 2.0e-3, 2.1e-3, 2.2e-3, 2.3e-3, 2.4e-3, 2.5e-3, 4e-3].map(&mut falls);
    assert!(found.windows(2).all(|pair| pair[1] < 1.02 * pair[0]), "{found:?}");
    assert!(found[0] > 20.0 && found[7] < 0.7, "{found:?}");
    // Three tenths at least are neither damped nor free.
    let between = found.iter().filter(|per_s| **per_s < 0.7 * found[0] && **per_s > 1.3 * found[7]).count();
    assert!(between >= 3, "{found:?}");
}
