//! A bridge that moves: a few modes of the soundboard at the place where the strings of a note end, which all of them
//! drive and which moves them all.
//!
//! **Energy.** Where the bridge is displaced by w, a string without inertia hangs straight, u = w x/L. In the string's
//! modes that is beta_n w with beta_n = b_n / (m omega_n^2), b_n being the mode's force on the bridge per metre. The
//! strings' potential energy is that of what they bend away from there,
//!
//! ```text
//! V = sum m omega_n^2 (q_n - beta_n w)^2 / 2 + (T/L) w^2 / 2      (never negative)
//! ```
//!
//! so that mode n feels the force b_n w, and the bridge F_b = S - K w with S = sum b_n q_n and K = sum b_n beta_n +
//! T/L: what acts one way acts the other way with the same number. The bridge's own modes are oscillators with M_k
//! r_k'' + ... = F_b and w = sum r_k.
//!
//! **A step.** The strings' modes move exactly under the mean w of the step's two ends, those of the bridge exactly
//! under the mean F_b. The work that the one does, w (S1 - S0), and that of the other, F_b (w1 - w0), add up to what V
//! has changed by, whatever the length of the step: no energy is gained, and nothing can become unstable. Both means
//! are linear in the hammer's force, so that it remains one scalar unknown.

use std::f64::consts::PI;

use super::rows::{Block, Row, transition};
use crate::instrument::BridgeMode;

/// The modes of the bridge, and what couples the strings to them.
#[derive(Debug, Clone, Default)]
pub(super) struct Bridge {
    modes: Vec<Own>,
    /// The effect of w on the strings' modes: their rows' "shape" is b_n.
    pub row: Row,
    /// K, N/m.
    stiffness_n_per_m: f64,
    /// Of all its modes: 1/k, and what a newton adds to w in a step, m/N.
    static_m_per_n: f64,
    gives_m_per_n: f64,
    /// Contribution of w to S in a step, N/m.
    answers_n_per_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Own {
    r: f64,
    v: f64,
    step: [f64; 4],
    mass_kg: f64,
    stiffness_n_per_m: f64,
}

impl Bridge {
    /// At rest. `row`: b_n of the strings' modes; `stiffness_n_per_m`: K; `answers_n_per_m`: sum b_n^2 (1 - P_11) / (m
    /// omega^2).
    pub(crate) fn new(
        modes: &[BridgeMode],
        row: Row,
        stiffness_n_per_m: f64,
        answers_n_per_m: f64,
        step_s: f64,
    ) -> Self {
        let own = |mode: &BridgeMode| {
            let omega = 2.0 * PI * mode.frequency_hz;
            let step = transition(omega, 0.5 * mode.loss_factor * omega, step_s);
            Own { r: 0.0, v: 0.0, step, mass_kg: mode.mass_kg, stiffness_n_per_m: mode.mass_kg * omega * omega }
        };
        let modes: Vec<Own> = modes.iter().map(own).collect();
        let static_m_per_n = modes.iter().map(|mode| 1.0 / mode.stiffness_n_per_m).sum();
        let gives_m_per_n = modes.iter().map(|mode| (1.0 - mode.step[0]) / mode.stiffness_n_per_m).sum();
        Bridge { modes, row, stiffness_n_per_m, static_m_per_n, gives_m_per_n, answers_n_per_m }
    }

    /// w, m.
    pub(crate) fn displacement_m(&self) -> f64 {
        self.modes.iter().map(|mode| mode.r).sum()
    }

    /// The force of strings of a given S on it, N.
    pub(crate) fn force_n(&self, s_n: f64) -> f64 {
        s_n - self.stiffness_n_per_m * self.displacement_m()
    }

    fn divisor(&self) -> f64 {
        2.0 + self.gives_m_per_n * (self.stiffness_n_per_m - 0.5 * self.answers_n_per_m)
    }

    /// By how much the mean w of a step rises per newton of S at its end, m/N.
    pub(crate) fn per_newton(&self) -> f64 {
        0.5 * self.gives_m_per_n / self.divisor()
    }

    /// The mean w of a step, m, in which S goes from one value to another if w stays zero.
    pub(crate) fn mean_m(&self, s_n: f64, s_free_n: f64) -> f64 {
        let free: f64 = self.modes.iter().map(|mode| mode.step[0] * mode.r + mode.step[1] * mode.v).sum();
        (self.displacement_m() + free + 0.5 * self.gives_m_per_n * (s_n + s_free_n)) / self.divisor()
    }

    /// Its modes' step under the mean force, N; what this has done to them, J.
    pub(crate) fn advance(&mut self, force_n: f64) -> f64 {
        let before_m = self.displacement_m();
        for mode in &mut self.modes {
            let [qq, qv, vq, vv] = mode.step;
            let rests = force_n / mode.stiffness_n_per_m;
            let (r, v) = (mode.r - rests, mode.v);
            (mode.r, mode.v) = (rests + qq * r + qv * v, vq * r + vv * v);
        }
        force_n * (self.displacement_m() - before_m)
    }

    /// The mean force of a step in which S and w have gone so far, N.
    pub(crate) fn mean_force_n(&self, s_n: [f64; 2], mean_m: f64) -> f64 {
        0.5 * (s_n[0] + s_n[1]) - self.stiffness_n_per_m * mean_m
    }

    /// Equilibrium position, m, under the strings' force at w = 0 without inertia, N: they hold the bridge like springs
    /// of T/L (`hold_n_per_m`).
    pub(crate) fn stands_m(&self, force_n: f64, hold_n_per_m: f64) -> f64 {
        force_n / (1.0 / self.static_m_per_n + hold_n_per_m)
    }

    /// Puts it where it stands under a force of the strings that includes what w takes back, N.
    pub(crate) fn stand(&mut self, force_n: f64) {
        for mode in &mut self.modes {
            (mode.r, mode.v) = (force_n / mode.stiffness_n_per_m, 0.0);
        }
    }

    /// Energy of its modes, J.
    pub(crate) fn own_energy_j(&self) -> f64 {
        let own = |mode: &Own| 0.5 * (mode.mass_kg * mode.v * mode.v + mode.stiffness_n_per_m * mode.r * mode.r);
        self.modes.iter().map(own).sum()
    }

    /// The same and that of K, without w S, J.
    pub(crate) fn energy_j(&self) -> f64 {
        let w = self.displacement_m();
        self.own_energy_j() + 0.5 * self.stiffness_n_per_m * w * w
    }

    /// What vibrates about where it stands under a force, J.
    pub(crate) fn trembles_j(&self, force_n: f64) -> f64 {
        let own = |mode: &Own| {
            let r = mode.r - force_n / mode.stiffness_n_per_m;
            0.5 * (mode.mass_kg * mode.v * mode.v + mode.stiffness_n_per_m * r * r)
        };
        self.modes.iter().map(own).sum()
    }

    /// S of the strings' modes.
    pub(crate) fn sum_n(&self, blocks: &[Block]) -> f64 {
        self.row.now(blocks)
    }

    /// Displacement and velocity of one of its modes.
    pub(crate) fn mode_now(&self, index: usize) -> [f64; 2] {
        self.modes.get(index).map_or([0.0; 2], |mode| [mode.r, mode.v])
    }

    /// Sets one of them.
    pub(crate) fn set_mode(&mut self, index: usize, velocity: bool, number: f64) {
        if let Some(mode) = self.modes.get_mut(index) {
            *(if velocity { &mut mode.v } else { &mut mode.r }) = number;
        }
    }

    /// Its modes are where those of another are, which has the same.
    pub(crate) fn go_on_from(&mut self, other: &Self) {
        for (mode, other) in self.modes.iter_mut().zip(&other.modes) {
            (mode.r, mode.v) = (other.r, other.v);
        }
    }
}
