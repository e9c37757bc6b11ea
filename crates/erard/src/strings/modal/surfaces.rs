//! What the engine asks of strings as of any surface that yields.

use std::any::Any;

use moreau::Surface;
use moreau_kernels::Surfaces;

use super::{Between, POINTS, Strings};
use crate::strings::bridge::Bridge;
use crate::strings::pedal::Rail;
use crate::strings::rows::WIDE;

/// Every so many steps it is seen whether the strings have come to rest.
const LOOK_EVERY: u64 = 64;
/// Strings that are still go on standing as they do where a force changes by less than this part of it: its rounding.
const SAME: f64 = 1e-10;

impl Surfaces for Strings {
    fn zones(&self) -> &[usize] {
        &self.zones
    }

    fn set_step(&mut self, step_s: f64) {
        if step_s == self.step_s {
            return;
        }
        let before = std::mem::take(&mut self.blocks);
        let modes = std::mem::take(&mut self.modes);
        let bridge: Vec<f64> = self.bridge.iter().flat_map(Bridge::numbers).collect();
        self.make_modes(step_s);
        // Modes that both reach go on as they were.
        for mode in &modes {
            let same = self.modes.iter().find(|other| (other.string, other.n) == (mode.string, mode.n));
            if let Some(same) = same {
                let (old, new) = (&before[mode.at / WIDE], &mut self.blocks[same.at / WIDE]);
                new.q[same.at % WIDE] = old.q[mode.at % WIDE];
                new.v[same.at % WIDE] = old.v[mode.at % WIDE];
            }
        }
        if let Some(own) = &mut self.bridge {
            own.set_numbers(&bridge);
        }
        if self.still {
            self.stand();
        } else {
            self.update_surfaces();
        }
    }

    fn follow(&mut self, statically: bool) {
        if statically && !self.statically {
            self.stand();
            self.still = true;
        }
        if !statically && self.statically {
            self.resting_n = self.forces_n;
        }
        self.statically = statically;
    }

    fn surface(&self, index: usize) -> Surface<f64> {
        let points = 1 + self.felts.len();
        if index >= points {
            return self.rail.unwrap_or_default().surface(self.step_s);
        }
        let displacement = self.point_now(index);
        if self.statically {
            return Surface { displacement, free: 0.0, compliance: self.static_m_n[index][index] };
        }
        let alone = index.checked_sub(1).map_or(self.free_m, |k| self.felts[k].row.free(&self.blocks));
        let mut compliance = self.compliance_m_n[index][index];
        if self.bridge.is_some() {
            let mut free = alone + self.sounds[index] * self.drifts_m;
            for (k, _) in self.rocking() {
                let held_n: f64 = self.rocking().map(|(l, rocks)| self.coupling[k][l] * rocks.drift_m).sum();
                free -= self.rocked_by(k, index) * held_n;
            }
            return Surface { displacement, free, compliance: compliance - self.held_m_n(index, index) };
        }
        let mut free = alone;
        for (k, rocks) in self.rocking() {
            let rocked = self.rocked_by(k, index);
            free -= rocked * rocks.stiff_n_m * rocks.drift_m;
            compliance -= rocked * rocks.stiff_n_m * rocked;
        }
        Surface { displacement, free, compliance }
    }

    fn coupled(&self, compliance: &mut Between, forces: &mut [f64; POINTS]) -> usize {
        *forces = self.forces_n;
        *compliance = self.static_m_n;
        if !self.statically {
            *compliance = self.compliance_m_n;
            if self.bridge.is_some() {
                for (a, row) in compliance.iter_mut().enumerate().take(1 + self.felts.len()) {
                    for (b, gives) in row.iter_mut().enumerate().take(1 + self.felts.len()).filter(|(b, _)| *b != a) {
                        *gives -= self.held_m_n(a, b);
                    }
                }
                return if self.felts.is_empty() { 0 } else { 1 + self.felts.len() };
            }
            for (k, rocks) in self.rocking() {
                let less = self.rocked_by(k, 0) * rocks.stiff_n_m * self.rocked_by(k, 1 + k);
                compliance[0][1 + k] -= less;
                compliance[1 + k][0] -= less;
            }
        }
        if self.felts.is_empty() { 0 } else { 1 + self.felts.len() }
    }

    fn advance(&mut self, forces: &[f64]) {
        let points = 1 + self.felts.len();
        if let Some(rail) = &mut self.rail {
            let after_m = rail.after(self.step_s);
            self.given_j += forces.get(points).copied().unwrap_or(0.0) * (after_m - rail.lift_m);
            rail.lift_m = after_m;
        }
        let same = |(force, before): (&f64, &f64)| (force - before).abs() <= SAME * before.abs();
        if self.still && forces[..points].iter().zip(&self.forces_n).all(same) {
            return;
        }
        let before_m: [f64; POINTS] =
            std::array::from_fn(|p| if p < points && forces[p] != 0.0 { self.point_now(p) } else { 0.0 });
        self.forces_n[..points].copy_from_slice(&forces[..points]);
        if self.statically {
            self.stand();
        } else {
            self.still = false;
            self.step_all();
            self.steps += 1;
            if self.steps.is_multiple_of(LOOK_EVERY) {
                self.settle();
            }
        }
        for (p, before_m) in before_m.iter().enumerate() {
            if self.forces_n[p] != 0.0 {
                self.work_j += self.forces_n[p] * (self.point_now(p) - before_m);
            }
        }
    }

    fn rests(&self) -> bool {
        self.still && !self.rail.is_some_and(|rail| rail.moves())
    }

    fn may_reach(&self, index: usize) -> bool {
        // The rail is where it is unless it is moved.
        index <= self.felts.len() || self.rail.is_some_and(|rail| rail.moves())
    }

    fn energy(&self) -> f64 {
        self.energy_j()
    }

    fn lost(&self) -> f64 {
        self.work_j - self.energy_j()
    }

    fn given(&self) -> f64 {
        self.given_j
    }

    fn numbers(&self) -> usize {
        2 * self.modes.len() + 2 * self.bridge.as_ref().map_or(0, Bridge::count) + POINTS + 8
    }

    fn save(&self, mut put: &mut dyn FnMut(f64)) {
        for mode in &self.modes {
            let block = &self.blocks[mode.at / WIDE];
            put(block.q[mode.at % WIDE]);
            put(block.v[mode.at % WIDE]);
        }
        self.bridge.iter().flat_map(Bridge::numbers).for_each(&mut put);
        self.forces_n.iter().for_each(|force_n| put(*force_n));
        let rail = self.rail.unwrap_or_default();
        [self.work_j, self.given_j, rail.lift_m, rail.aim_m, self.bridge_j, self.rocked_j]
            .into_iter()
            .for_each(&mut put);
        put((self.steps % LOOK_EVERY) as f64);
        put(f64::from(u8::from(self.still)));
    }

    fn restore(&mut self, from: &[f64]) {
        // Snapshots of before losses were kept by kind lack two numbers.
        if from.len() != self.numbers() && from.len() + 2 != self.numbers() {
            self.reset_to_equilibrium();
            (self.work_j, self.given_j, self.rocked_j, self.steps) = (0.0, 0.0, 0.0, 0);
            self.bridge_j = self.bridge.as_ref().map_or(0.0, Bridge::own_energy_j);
            self.rail = self.rail.map(|_| Rail::default());
            return;
        }
        let (own, from) = from.split_at(2 * self.modes.len());
        for (mode, numbers) in self.modes.iter().zip(own.chunks_exact(2)) {
            let block = &mut self.blocks[mode.at / WIDE];
            (block.q[mode.at % WIDE], block.v[mode.at % WIDE]) = (numbers[0], numbers[1]);
        }
        let (own, from) = from.split_at(2 * self.bridge.as_ref().map_or(0, Bridge::count));
        if let Some(bridge) = &mut self.bridge {
            bridge.set_numbers(own);
        }
        let (forces_n, rest) = from.split_at(POINTS);
        self.forces_n.copy_from_slice(forces_n);
        (self.work_j, self.given_j) = (rest[0], rest[1]);
        self.rail = self.rail.map(|_| Rail { lift_m: rest[2], aim_m: rest[3] });
        let (by_kind, rest) = rest[4..].split_at(rest.len() - 6);
        (self.bridge_j, self.rocked_j) = match *by_kind {
            [bridge_j, rocked_j] => (bridge_j, rocked_j),
            _ => (self.bridge.as_ref().map_or(0.0, Bridge::own_energy_j), 0.0),
        };
        (self.steps, self.still) = (rest[0] as u64, rest[1] != 0.0);
        self.update_surfaces();
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
