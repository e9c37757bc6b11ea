//! Strings as compliant surfaces for the engine.

use std::any::Any;

use moreau::Surface;
use moreau_kernels::{Parts, Surfaces, TellNumbers};

use super::{Between, POINTS, Strings};
use crate::identity::by_name;
use crate::instrument::MAX_STRINGS;
use crate::strings::bridge::{Bridge, dot};
use crate::strings::damping::felt_of;
use crate::strings::pedal::Rail;
use crate::strings::rows::WIDE;

/// Number of steps between tests whether the strings have come to rest.
const LOOK_EVERY: u64 = 64;
/// Strings that are still go on standing as they do where a force changes by less than this part of it: its rounding.
const SAME: f64 = 1e-10;

/// Indices, each below the number of places.
fn order<const K: usize>(indices: impl Iterator<Item = usize>) -> [usize; K] {
    let mut order = [0; K];
    order.iter_mut().zip(indices).for_each(|(place, index)| *place = index);
    order
}

/// A saved state's order: that of names, whatever that in the file. Nothing here allocates.
impl Strings {
    fn strings_by_name(&self) -> impl Iterator<Item = usize> + use<> {
        let order: [usize; MAX_STRINGS] = by_name(self.strings.iter().map(|string| string.name.as_str()));
        order.into_iter().take(self.strings.len())
    }

    fn felts_by_name(&self) -> impl Iterator<Item = usize> + '_ {
        self.strings_by_name().filter_map(|string| self.felts.iter().position(|felt| felt.string == string))
    }
}

impl Surfaces for Strings {
    fn zones(&self) -> &[usize] {
        &self.zones
    }

    fn parts(&self, step_s: f64) -> Parts {
        self.parts_of(step_s)
    }

    fn set_step(&mut self, step_s: f64, parts: &Parts) {
        if (step_s, *parts) != self.prepared_for {
            self.prepare(step_s, parts);
        } else if self.near {
            self.change_parts();
        }
    }

    fn take(&mut self, near: bool) {
        if near != self.near {
            self.change_parts();
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
            return Surface { displacement, free: 0.0, compliance: self.static_m_per_n[index][index] };
        }
        let alone = index.checked_sub(1).map_or(self.free_m, |k| self.felts[k].row.free(&self.blocks));
        let mut compliance = self.compliance_m_per_n[index][index];
        if self.is_joint() {
            let mut free = alone + dot(self.sounds[index], self.drifts_m);
            for (k, _) in self.rocking() {
                let held_n: f64 = self.rocking().map(|(l, rocks)| self.coupling[k][l] * rocks.drift_m).sum();
                free -= self.rocked_m_per_n[k][index] * held_n;
            }
            return Surface { displacement, free, compliance: compliance - self.held_m_per_n[index][index] };
        }
        let mut free = alone;
        for (k, rocks) in self.rocking() {
            let rocked = self.rocked_m_per_n[k][index];
            free -= rocked * rocks.stiff_n_per_m * rocks.drift_m;
            compliance -= rocked * rocks.stiff_n_per_m * rocked;
        }
        Surface { displacement, free, compliance }
    }

    fn coupled(&self, compliance: &mut Between, forces: &mut [f64; POINTS]) -> usize {
        *forces = self.forces_n;
        *compliance = self.static_m_per_n;
        if !self.statically {
            *compliance = self.compliance_m_per_n;
            if self.is_joint() {
                for (a, row) in compliance.iter_mut().enumerate().take(1 + self.felts.len()) {
                    for (b, gives) in row.iter_mut().enumerate().take(1 + self.felts.len()).filter(|(b, _)| *b != a) {
                        *gives -= self.held_m_per_n[a][b];
                    }
                }
                return if self.felts.is_empty() { 0 } else { 1 + self.felts.len() };
            }
            for (k, rocks) in self.rocking() {
                let (felt, _) = felt_of(k);
                let less = self.rocked_m_per_n[k][0] * rocks.stiff_n_per_m * self.rocked_m_per_n[k][1 + felt];
                compliance[0][1 + felt] -= less;
                compliance[1 + felt][0] -= less;
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
                self.swings_m = self.largest_swings_m();
            } else if !self.untouched() {
                self.swings_m = [f64::INFINITY; POINTS];
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

    fn reach(&self, index: usize) -> f64 {
        match &self.rail {
            _ if index <= self.felts.len() => self.swings_m[index],
            Some(rail) if rail.moves() => f64::INFINITY,
            // The rail is where it is.
            _ => f64::NEG_INFINITY,
        }
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

    fn save(&self, put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>)) {
        let modes = self.strings_by_name().flat_map(|string| self.modes_of(string));
        put("string_modes", &mut modes.flat_map(|(_, at)| self.mode_now(at)));
        let bridge =
            self.bridge.iter().flat_map(|bridge| self.bridge_order.iter().map(|index| bridge.mode_now(*index)));
        put("string_bridge_modes", &mut bridge.flatten());
        put("string_hammer_N", &mut std::iter::once(self.forces_n[0]));
        put("string_dampers_N", &mut self.felts_by_name().map(|felt| self.forces_n[1 + felt]));
        let rail = self.rail.unwrap_or_default();
        let single = [
            ("string_work_J", self.work_j),
            ("string_given_J", self.given_j),
            ("string_rail_m", rail.lift_m),
            ("string_rail_aim_m", rail.aim_m),
            ("string_bridge_J", self.bridge_j),
            ("string_rocked_J", self.rocked_j),
            ("string_steps", (self.steps % LOOK_EVERY) as f64),
            ("string_still", f64::from(u8::from(self.still))),
        ];
        single.into_iter().for_each(|(name, number)| put(name, &mut std::iter::once(number)));
    }

    fn restore(&mut self, each: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize) {
        let single = |name| {
            let mut found = None;
            each(name, &mut |_, number| found = Some(number));
            found
        };
        let or_zero = |name| single(name).unwrap_or(0.0);
        self.rail = self.rail.map(|_| Rail { lift_m: or_zero("string_rail_m"), aim_m: or_zero("string_rail_aim_m") });
        // Other modes, or none: at rest.
        let count = each("string_modes", &mut |_, _| {});
        let bridge = each("string_bridge_modes", &mut |_, _| {});
        if count != 2 * self.modes.len() || bridge != 2 * self.bridge_modes.len() {
            self.reset_to_equilibrium();
            (self.work_j, self.given_j, self.rocked_j, self.steps) = (0.0, 0.0, 0.0, 0);
            self.bridge_j = self.bridge.as_ref().map_or(0.0, Bridge::own_energy_j);
            self.rail = self.rail.map(|_| Rail::default());
            return;
        }
        self.swings_m = [f64::INFINITY; POINTS];
        let (strings, felts): ([usize; MAX_STRINGS], [usize; MAX_STRINGS]) =
            (order(self.strings_by_name()), order(self.felts_by_name()));
        let modes = &self.modes;
        let of = |string: usize| modes.iter().filter(move |mode| mode.string == string);
        let mut modes = strings.into_iter().take(self.strings.len()).flat_map(of);
        let bridge_modes = &self.bridge_order;
        let (blocks, mut at) = (&mut self.blocks, 0);
        each("string_modes", &mut |index, number| {
            if index % 2 == 0 {
                at = modes.next().map_or(at, |mode| mode.at);
                blocks[at / WIDE].q[at % WIDE] = number;
            } else {
                blocks[at / WIDE].v[at % WIDE] = number;
            }
        });
        if let Some(bridge) = &mut self.bridge {
            each("string_bridge_modes", &mut |index, number| {
                bridge.set_mode(bridge_modes[index / 2], index % 2 == 1, number);
            });
        }
        self.forces_n = [0.0; POINTS];
        self.forces_n[0] = or_zero("string_hammer_N");
        let (forces_n, count) = (&mut self.forces_n, self.felts.len());
        each("string_dampers_N", &mut |index, number| {
            if index < count {
                forces_n[1 + felts[index]] = number;
            }
        });
        (self.work_j, self.given_j) = (or_zero("string_work_J"), or_zero("string_given_J"));
        (self.bridge_j, self.rocked_j) = (or_zero("string_bridge_J"), or_zero("string_rocked_J"));
        (self.steps, self.still) = (or_zero("string_steps") as u64, or_zero("string_still") != 0.0);
        self.update_surfaces();
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
