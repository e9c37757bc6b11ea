//! A haptic key in closed loop with the simulated action: what can be rendered stably, and what cannot.
//!
//! ```text
//! device   m x'' = f_hand - b x' - c sign(x') - f_motor         a key with a motor: mass m, damping b, dry friction c
//! motor    tau f_motor' = f_told - f_motor,  |f_told| <= limit  its current follows with a lag
//! loop     every T: x is sampled in quanta, its speed estimated over a window; the action takes T, and what its fingertip gave is applied a period later
//! hand     a constant force, or Hand's mass on muscle
//! ```
//!
//! Between device and key stands the fingertip, spring K and damper B, that only pushes: the virtual coupling (Colgate,
//! Stanley and Brown 1995; Adams and Hannaford 1999). What the device feels is never stiffer than it. Two bounds from
//! theory, both for a spring-damper wall:
//!
//! - Colgate and Schenkel 1997: passive, sampled without delay, if b > K T / 2 + |B|. A delay t_d asks for K t_d more
//!   (to first order).
//! - Abbott and Okamura 2005: quanta d of the encoder feed no energy in if K < 2 c / d, with the device's dry friction
//!   c.

use erard::{Action, Input, Instrument, Settings};

/// The device and its loop.
#[derive(Debug, Clone, Copy)]
pub struct Device {
    /// Mass at the key front, kg.
    pub mass_kg: f64,
    /// Its own damping, N s/m.
    pub damping_n_s_per_m: f64,
    /// Its dry friction, N.
    pub friction_n: f64,
    /// Lag of the motor's current, s.
    pub lag_s: f64,
    /// Largest force of the motor, N.
    pub limit_n: f64,
    /// Quantum of the encoder, m.
    pub quantum_m: f64,
    /// Period of the loop, s: 1e-3, 250e-6 or 50e-6.
    pub period_s: f64,
    /// Periods between a sample and the force that answers it.
    pub latency: usize,
    /// Window over which the speed is estimated, s; at least a period.
    pub window_s: f64,
}

impl Device {
    /// A good motor key, as an estimate: 50 g at the front, an encoder of 1 um, a motor of 40 N with a lag of 0.2 ms,
    /// 0.1 N of friction.
    pub fn usual(rate_hz: f64, damping_n_s_per_m: f64) -> Self {
        Device {
            mass_kg: 0.05,
            damping_n_s_per_m,
            friction_n: 0.1,
            lag_s: 0.2e-3,
            limit_n: 40.0,
            quantum_m: 1e-6,
            period_s: 1.0 / rate_hz,
            latency: 1,
            window_s: 0.5e-3,
        }
    }

    /// From a position to the force that answers it, s, beside the half period of the hold.
    pub fn delay_s(&self) -> f64 {
        self.latency as f64 * self.period_s + self.lag_s
    }

    /// The stiffest coupling that Colgate's condition allows with this delay and a coupling's damper B, N/m.
    pub fn passive_n_per_m(&self, coupling_damping: f64, with_delay: bool) -> f64 {
        let t = 0.5 * self.period_s + if with_delay { self.delay_s() } else { 0.0 };
        ((self.damping_n_s_per_m - coupling_damping) / t).max(0.0)
    }

    /// The stiffest coupling whose quanta the friction takes up, N/m.
    pub fn quantised_n_per_m(&self) -> f64 {
        2.0 * self.friction_n / self.quantum_m
    }
}

/// Who presses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finger {
    /// A constant force, N: no mass and no damping of its own.
    Force(f64),
    /// 0.2 kg on muscle of 1500 N/m and 5 N s/m that goes to 12 mm below the rest of the key.
    Hand,
}

/// A finger that presses.
struct Pressing {
    finger: Finger,
    at_m: f64,
    speed_m_per_s: f64,
}

impl Pressing {
    /// The force on a device that is at `x`, m, with speed `v`, m/s, over the next [`FINE_S`], N. A hand moves on by as
    /// much.
    fn push(&mut self, x: f64, v: f64) -> f64 {
        match self.finger {
            Finger::Force(force_n) => force_n,
            Finger::Hand => {
                // Through a fingertip of its own, which only pushes.
                let tip_n = (2e4 * (self.at_m - x) + 20.0 * (self.speed_m_per_s - v)).max(0.0);
                let muscle_n = 1500.0 * (12e-3 - self.at_m) - 5.0 * self.speed_m_per_s;
                self.speed_m_per_s += (muscle_n - tip_n) / 0.2 * FINE_S;
                self.at_m += self.speed_m_per_s * FINE_S;
                tip_n
            }
        }
    }
}

/// The outcome of a press, held for a second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Root mean square of the device's speed in the last tenth of it, m/s.
    pub trembling_m_per_s: f64,
    /// That speed half a second earlier.
    pub earlier_m_per_s: f64,
    /// The largest force that was asked of the motor, N.
    pub largest_n: f64,
    /// Speed of the fastest impact, m/s; 0 without one.
    pub hammer_speed_m_per_s: f64,
    /// Whether the force of the motor was at its limit.
    pub saturated: bool,
}

impl Outcome {
    /// Whether it is still, or becomes so: trembling that no finger feels (1 mm/s is some 5 um at 30 Hz, an estimate),
    /// or that dies away. What a soft coupling on a device of little damping does for a while is no trembling of the
    /// loop.
    pub fn is_still(&self) -> bool {
        self.trembling_m_per_s < 1e-3 || self.trembling_m_per_s < 0.8 * self.earlier_m_per_s
    }
}

const STEP_S: f64 = 50e-6;
/// The device is integrated in steps of this length, s.
const FINE_S: f64 = 5e-6;
const END_S: f64 = 1.0;
/// Where the speed is looked at, s: from the beginning of each for a tenth of a second.
const LOOKED_S: [f64; 2] = [0.4, 0.9];

/// The loop by position and force (impedance): the device says where it is, and gives back what the fingertip gives.
/// `coupling`: its stiffness, N/m, and its damping, N s/m; `rigid` imposes the position on the key instead, with no
/// coupling at all.
pub fn play(instrument: &Instrument, device: &Device, coupling: [f64; 2], finger: Finger, rigid: bool) -> Outcome {
    let mut own = instrument.clone();
    let couple = |fields: &mut erard::instrument::InstrumentFields| {
        [fields.finger.stiffness_n_per_m, fields.finger.damping_n_s_per_m] = coupling;
    };
    own.edit(couple).expect("numbers alone");
    let mut action = Action::with(&own, Settings::new(STEP_S)).expect("it comes to rest");
    let sub_steps = (device.period_s / STEP_S).round() as usize;
    let fine = (device.period_s / FINE_S).round() as usize;
    let window = (device.window_s / device.period_s).round().max(1.0) as usize;
    let (mut x, mut v, mut motor_n) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut pressing = Pressing { finger, at_m: 0.0, speed_m_per_s: 0.0 };
    let mut told = std::collections::VecDeque::from(vec![0.0; device.latency]);
    let mut seen = std::collections::VecDeque::from(vec![0.0; window]);
    let mut out = Outcome {
        trembling_m_per_s: 0.0,
        earlier_m_per_s: 0.0,
        largest_n: 0.0,
        hammer_speed_m_per_s: 0.0,
        saturated: false,
    };
    let mut squares = [(0.0, 0_u32); 2];
    for n in 0..(END_S / device.period_s) as usize {
        let t = n as f64 * device.period_s;
        // What the loop knows.
        let at = device.quantum_m * (x / device.quantum_m).round();
        let speed = (at - seen.pop_front().unwrap_or(at)) / (window as f64 * device.period_s);
        seen.push_back(at);
        let mut sum = 0.0;
        for k in 0..sub_steps {
            let later = (k as f64 + if rigid { 1.0 } else { 0.5 }) * STEP_S;
            let position_m = at + speed * later;
            let input = if rigid {
                Input::Rigid { position_m, velocity_m_per_s: speed }
            } else {
                Input::Motion { position_m, velocity_m_per_s: speed }
            };
            let reading = action.step(input);
            if let Some(impact) = action.impact() {
                out.hammer_speed_m_per_s = out.hammer_speed_m_per_s.max(impact.hammer_speed_m_per_s);
            }
            sum += reading.finger_force_n;
        }
        told.push_back(sum / sub_steps as f64);
        let asked: f64 = told.pop_front().unwrap_or(0.0);
        out.largest_n = out.largest_n.max(asked.abs());
        out.saturated |= asked.abs() > device.limit_n;
        let asked = asked.clamp(-device.limit_n, device.limit_n);
        // The device until the next sample.
        for _ in 0..fine {
            let hand_n = pressing.push(x, v);
            motor_n += (asked - motor_n) * (1.0 - (-FINE_S / device.lag_s).exp());
            let push_n = hand_n - motor_n - device.damping_n_s_per_m * v;
            // Dry friction as an impulse that at most stops.
            let free = v + push_n / device.mass_kg * FINE_S;
            let most = device.friction_n / device.mass_kg * FINE_S;
            v = if free.abs() <= most { 0.0 } else { free - most * free.signum() };
            x += v * FINE_S;
            // The device's own stops.
            if !(-1e-3..=30e-3).contains(&x) {
                x = x.clamp(-1e-3, 30e-3);
                v = 0.0;
            }
            for (from, (sum, count)) in LOOKED_S.iter().zip(&mut squares) {
                if (*from..from + 0.1).contains(&t) {
                    *sum += v * v;
                    *count += 1;
                }
            }
        }
    }
    [out.earlier_m_per_s, out.trembling_m_per_s] = squares.map(|(sum, count)| (sum / f64::from(count.max(1))).sqrt());
    out
}

/// The loop by force and position (admittance): the finger's force on the device is measured, the action says where its
/// key is, and a servo of the given bandwidth, Hz, takes the device there; mass and friction of the device are the
/// servo's affair.
pub fn play_admittance(instrument: &Instrument, period_s: f64, bandwidth_hz: f64, finger: Finger) -> Outcome {
    let mut action = Action::with(instrument, Settings::new(STEP_S)).expect("it comes to rest");
    let sub_steps = (period_s / STEP_S).round() as usize;
    let fine = (period_s / FINE_S).round() as usize;
    let (mut x, mut v, mut measured_n) = (0.0_f64, 0.0_f64, 0.0);
    let mut pressing = Pressing { finger, at_m: 0.0, speed_m_per_s: 0.0 };
    let own = 2.0 * std::f64::consts::PI * bandwidth_hz;
    let mut out = Outcome {
        trembling_m_per_s: 0.0,
        earlier_m_per_s: 0.0,
        largest_n: 0.0,
        hammer_speed_m_per_s: 0.0,
        saturated: false,
    };
    let mut squares = [(0.0, 0_u32); 2];
    for n in 0..(END_S / period_s) as usize {
        let t = n as f64 * period_s;
        let mut key_m = 0.0;
        for _ in 0..sub_steps {
            key_m = action.step(Input::Force(measured_n)).key_m;
            if let Some(impact) = action.impact() {
                out.hammer_speed_m_per_s = out.hammer_speed_m_per_s.max(impact.hammer_speed_m_per_s);
            }
        }
        let mut sum = 0.0;
        for _ in 0..fine {
            let hand_n = pressing.push(x, v);
            sum += hand_n;
            // A servo of second order, damped as well as can be.
            v += (own * own * (key_m - x) - 2.0 * own * v) * FINE_S;
            x += v * FINE_S;
            for (from, (sum, count)) in LOOKED_S.iter().zip(&mut squares) {
                if (*from..from + 0.1).contains(&t) {
                    *sum += v * v;
                    *count += 1;
                }
            }
        }
        measured_n = sum / fine as f64;
        out.largest_n = out.largest_n.max(measured_n);
    }
    [out.earlier_m_per_s, out.trembling_m_per_s] = squares.map(|(sum, count)| (sum / f64::from(count.max(1))).sqrt());
    out
}

/// The stiffest coupling without a damper, N/m, up to which the device is still under every finger: from half of the
/// passive coupling on in steps of a twentieth, the last of them to a fiftieth, up to 1e6. 0 where that half is not
/// still.
///
/// It goes up and does not bisect from afar: a coupling can be still that is stiffer than one that trembles. Where the
/// delay feeds energy in, dry friction takes up small motions only, and which coupling lets a press end in a small one
/// does not follow their stiffness.
pub fn stiffest_still(instrument: &Instrument, device: &Device) -> f64 {
    let is_still = |stiffness: f64| {
        [Finger::Force(6.0), Finger::Force(2.0), Finger::Hand]
            .into_iter()
            .all(|finger| play(instrument, device, [stiffness, 0.0], finger, false).is_still())
    };
    let (mut low, mut high) = (0.0, 0.5 * device.passive_n_per_m(0.0, true));
    while low < 1e6 && is_still(high) {
        (low, high) = (high, 1.05 * high);
    }
    while low > 0.0 && high / low > 1.02 {
        let middle = (low * high).sqrt();
        if is_still(middle) { low = middle } else { high = middle }
    }
    low
}
