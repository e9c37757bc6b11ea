//! Freely ringing strings, advanced over any span at once.

use super::{Mode, POINTS, Strings, free_motion};
use crate::strings::rows::WIDE;

impl Strings {
    /// Whether nothing has touched them in the last step.
    pub(super) fn untouched(&self) -> bool {
        self.forces_n.iter().all(|force_n| *force_n == 0.0) && self.rocks.iter().all(|rocks| rocks.stiff_n_per_m == 0.0)
    }

    /// Whether each mode moves freely, on a bridge that does not move, and no damper is moved.
    pub(crate) fn ring_freely(&self) -> bool {
        let moved = self.rail.is_some_and(|rail| rail.moves());
        self.bridge.is_none() && self.untouched() && !(self.still || self.statically || moved)
    }

    /// Lets them ring freely for a number of spans of a length, s, and shows them after each span. The motion of a free
    /// mode is exact over any span: this differs from steps by rounding.
    pub(crate) fn ring(&mut self, spans: u64, span_s: f64, each: &mut dyn FnMut(&Self)) {
        let free = |mode: &Mode| free_motion(&self.strings[mode.string], mode.n, span_s);
        let transitions: Vec<[f64; 4]> = self.modes.iter().map(free).collect();
        for _ in 0..spans {
            for (mode, [qq, qv, vq, vv]) in self.modes.iter().zip(&transitions) {
                let (block, place) = (&mut self.blocks[mode.at / WIDE], mode.at % WIDE);
                let (q, v) = (block.q[place], block.v[place]);
                (block.q[place], block.v[place]) = (qq * q + qv * v, vq * q + vv * v);
            }
            self.update_surfaces();
            each(self);
        }
        self.settle();
    }

    /// Largest swing of a mode if nothing touches it, m: its energy does not grow.
    fn amplitude_m(&self, mode: &Mode) -> f64 {
        (2.0 * self.mode_energy_j(mode) / mode.stiffness_n_per_m).sqrt()
    }

    /// How far each place swings at most, with all modes in step, m; unknown while something touches the strings. Where
    /// a bridge moves, modes exchange energy, but all together have no more than now: a place of static compliance C is
    /// then displaced by sqrt(2 E C) at most.
    pub(super) fn largest_swings_m(&self) -> [f64; POINTS] {
        if !self.untouched() {
            return [f64::INFINITY; POINTS];
        }
        if self.bridge.is_some() {
            let energy_j = self.energy_j().max(0.0);
            return std::array::from_fn(|p| (2.0 * energy_j * self.static_m_per_n[p][p]).sqrt());
        }
        let mut swings_m = [0.0; POINTS];
        for mode in &self.modes {
            let amplitude_m = self.amplitude_m(mode);
            for (p, swing_m) in swings_m.iter_mut().enumerate() {
                *swing_m += self.shape(p, mode).abs() * amplitude_m;
            }
        }
        swings_m
    }

    /// The force on the bridge, N, up or down, that all modes in step with each other would make: strings that nothing
    /// touches make no larger one from now on. On a bridge that moves all together have no more than their energy E,
    /// and make sqrt(2 E K) at most.
    #[must_use]
    pub fn largest_bridge_n(&self) -> f64 {
        if let Some(bridge) = &self.bridge {
            return (2.0 * self.energy_j().max(0.0) * bridge.stiffness_n_per_m()).sqrt();
        }
        let bridge_n_per_m = |mode: &Mode| self.blocks[mode.at / WIDE].bridge[mode.at % WIDE];
        let vertical = self.modes.iter().filter(|mode| mode.direction == 0);
        vertical.map(|mode| bridge_n_per_m(mode).abs() * self.amplitude_m(mode)).sum()
    }
}
