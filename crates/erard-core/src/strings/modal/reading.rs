//! Readings of strings, and where the pedal is sent.

use super::{Mode, Strings};
use crate::index::IndexError;
use crate::instrument::PianoString;
use crate::strings::StringLosses;
use crate::strings::bridge::dot;
use crate::strings::rows::WIDE;

impl Strings {
    /// The strings.
    #[must_use]
    pub fn strings(&self) -> &[PianoString] {
        &self.strings
    }

    /// Number of modes that are stepped.
    #[must_use]
    pub fn modes(&self) -> usize {
        self.modes.len()
    }

    /// Displacement under the felt now, m, away from the hammer; of several strings their mean.
    #[must_use]
    pub fn displacement_m(&self) -> f64 {
        self.now_m
    }

    /// Force of all strings on the bridge now, N, in the direction in which the hammer pushes them; of the modes that
    /// are stepped. What lies on the strings is part of it.
    #[must_use]
    pub fn bridge_n(&self) -> f64 {
        self.bridge_forces_n()[0]
    }

    /// Forces of all strings on the bridge now, N: in the direction of the blow, as [`Strings::bridge_n`], and across
    /// it.
    #[must_use]
    pub fn bridge_forces_n(&self) -> [f64; 2] {
        self.bridge.as_ref().map_or(self.sum_n, |bridge| bridge.force_n(self.sum_n))
    }

    /// Sound pressure now at two places 1 m before the board, Pa, half a metre apart, without the way of the sound to
    /// them and without a room: an estimate. `None` where no board moves.
    #[must_use]
    pub fn pressure_pa(&self) -> Option<[f64; 2]> {
        self.bridge.as_ref().map(|bridge| bridge.weighted(&self.radiated))
    }

    /// Displacement of the bridge in the direction of the blow now, m; 0 where it does not move.
    #[must_use]
    pub fn bridge_m(&self) -> f64 {
        self.bridge.as_ref().map_or(0.0, |bridge| bridge.displacement_m()[0])
    }

    /// Forces of the dampers' felts on their strings in the last step, N, in the strings' order; of strings that a
    /// damper lies on.
    pub fn damper_n(&self) -> impl Iterator<Item = f64> + '_ {
        self.forces_n[1..=self.felts.len()].iter().copied()
    }

    /// Lift of the pedal's rail now, m; `None` without a rail.
    #[must_use]
    pub fn pedal_m(&self) -> Option<f64> {
        self.rail.map(|rail| rail.lift_m)
    }

    /// Where it was sent, m.
    #[must_use]
    pub(crate) fn pedal_aim_m(&self) -> Option<f64> {
        self.rail.map(|rail| rail.aim_m)
    }

    /// Sends the pedal's rail to a lift, m, from 0 (up) to [`crate::strings::MAX_PEDAL_M`]; it goes there at
    /// [`crate::strings::PEDAL_M_PER_S`] at most. NaN changes nothing.
    pub fn set_pedal(&mut self, lift_m: f64) {
        if let Some(rail) = &mut self.rail {
            rail.aim(lift_m);
        }
    }

    /// A string's displacement in the direction of the blow at a place now, m, of the modes that are stepped;
    /// `place_m` from the end that the strike is counted from.
    ///
    /// # Errors
    /// There is no such string.
    pub fn shape_m(&self, string: usize, place_m: f64) -> Result<f64, IndexError> {
        IndexError::check("string", string, self.strings.len())?;
        let length_m = self.strings[string].length_m;
        let own = self.modes.iter().filter(|mode| mode.string == string && mode.direction == 0);
        let shapes = own
            .map(|mode| PianoString::shape(mode.n, place_m, length_m) * self.blocks[mode.at / WIDE].q[mode.at % WIDE]);
        Ok(shapes.sum())
    }

    /// The modes of a string in both directions: number, and place in the blocks.
    pub(in crate::strings) fn modes_of(&self, string: usize) -> impl Iterator<Item = (u32, usize)> + '_ {
        self.modes.iter().filter(move |mode| mode.string == string).map(|mode| (mode.n, mode.at))
    }

    /// A mode's displacement now, m.
    pub(in crate::strings) fn mode_m(&self, block: usize, lane: usize) -> f64 {
        self.blocks.get(block).map_or(0.0, |block| block.q[lane])
    }

    /// Losses since the strings were made, by kind.
    #[must_use]
    pub fn losses(&self) -> StringLosses {
        let bridge_j = self.bridge.as_ref().map_or(0.0, |bridge| self.bridge_j - bridge.own_energy_j());
        let rocking_j = self.rocked_j;
        StringLosses { strings_j: self.work_j - self.energy_j() - bridge_j - rocking_j, bridge_j, rocking_j }
    }

    /// Whether they end on a bridge that moves, and whether dampers' felts lie on them.
    #[must_use]
    pub(crate) fn bears(&self) -> [bool; 2] {
        [self.bridge.is_some(), !self.felts.is_empty()]
    }

    /// The modes of a string in the direction of the blow.
    pub(in crate::strings) fn vertical_modes_of(&self, string: usize) -> impl Iterator<Item = (u32, usize)> + '_ {
        let is_own = move |mode: &&super::Mode| (mode.string, mode.direction) == (string, 0);
        self.modes.iter().filter(is_own).map(|mode| (mode.n, mode.at))
    }

    /// Displacement, m, and velocity, m/s, of a string's partial in the direction of the blow now; `None` where it is
    /// not stepped.
    #[must_use]
    pub fn partial(&self, string: usize, n: u32) -> Option<[f64; 2]> {
        self.partial_of(string, n, 0)
    }

    /// Likewise across the blow: of a string that moves sideways.
    #[must_use]
    pub fn partial_sideways(&self, string: usize, n: u32) -> Option<[f64; 2]> {
        self.partial_of(string, n, 1)
    }

    fn partial_of(&self, string: usize, n: u32, direction: usize) -> Option<[f64; 2]> {
        let is_it = |mode: &&super::Mode| (mode.string, mode.n, mode.direction) == (string, n, direction);
        let mode = self.modes.iter().find(is_it)?;
        Some(self.mode_now(mode.at))
    }

    /// Displacement, m, and velocity, m/s, of the mode at a place of the blocks.
    pub(super) fn mode_now(&self, at: usize) -> [f64; 2] {
        let block = &self.blocks[at / WIDE];
        [block.q[at % WIDE], block.v[at % WIDE]]
    }

    /// Energy of a mode, J.
    pub(super) fn mode_energy_j(&self, mode: &Mode) -> f64 {
        let [q, v] = self.mode_now(mode.at);
        0.5 * (mode.mass_kg * v * v + mode.stiffness_n_per_m * q * q)
    }

    /// Energy of the modes, of the bridge and of what follows statically, J.
    pub(super) fn energy_j(&self) -> f64 {
        let modes: f64 = self.modes.iter().map(|mode| self.mode_energy_j(mode)).sum();
        let mut beyond = 0.0;
        for (row, force_n) in self.beyond_m_per_n.iter().zip(&self.forces_n) {
            for (compliance, other_n) in row.iter().zip(&self.forces_n) {
                beyond += 0.5 * compliance * force_n * other_n;
            }
        }
        let bridge = self.bridge.as_ref();
        let bridge = bridge.map_or(0.0, |bridge| bridge.energy_j() - dot(bridge.displacement_m(), self.sum_n));
        modes + beyond + bridge
    }
}
