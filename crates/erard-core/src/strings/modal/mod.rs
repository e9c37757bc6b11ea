//! The strings of a note in their modes, and their step. The engine's queries are in `surfaces.rs`, the readings in
//! `reading.rs`.

mod parts;
mod reading;
mod ring;
mod surfaces;

use core::f64::consts::PI;

use moreau_kernels::{Mechanism, Parts, Readout};

use super::bridge::{Bridge, Pair, dot};
use super::damping::{self, Coupling, DASHPOTS, Felt, Rocks, all_rocks, coupling, felt_of};
use super::pedal::Rail;
use super::rows::{Block, Row, WIDE, added, transition};
use crate::identity::by_name;
use crate::instrument::REACH_HZ;
use crate::instrument::{Instrument, MAX_BRIDGE_MODES, MAX_STRINGS, PianoString};
use crate::radiation;

/// J; strings whose vibration holds less than this are still. A pianissimo puts 1e-3 J into them: 150 dB less. Decaying
/// for ever, they would end in numbers that are slow to compute with (denormal ones).
const STILL_J: f64 = 1e-18;
/// J; likewise for a single mode among others.
const MODE_STILL_J: f64 = 1e-30;
/// Places at which strings are pressed: the hammer's, and a damper's on each string.
const POINTS: usize = 1 + MAX_STRINGS;

/// A number for every two of them.
type Between = [[f64; POINTS]; POINTS];

/// What is seldom needed of a mode.
#[derive(Debug, Clone, Copy)]
struct Mode {
    string: usize,
    /// 0 in the direction of the blow, 1 across it.
    direction: usize,
    n: u32,
    /// Its place in the blocks.
    at: usize,
    mass_kg: f64,
    /// m omega^2, N/m.
    stiffness_n_per_m: f64,
}

/// What depends on the length of a step: all of it is prepared for both lengths, and that of one is in use.
#[derive(Debug, Clone)]
struct Prepared {
    step_s: f64,
    blocks: Vec<Block>,
    felts: Vec<Felt>,
    bridge: Option<Bridge>,
    compliance_m_per_n: Between,
    sounds: [Pair; POINTS],
    rocked_m_per_n: [[f64; POINTS]; DASHPOTS],
}

/// The exact motion of a string's mode, which is free, over a span, s: see [`transition`].
fn free_motion(string: &PianoString, n: u32, span_s: f64) -> [f64; 4] {
    transition(2.0 * PI * string.partial_hz(n), string.decay_per_s(n), span_s)
}

/// By how much a newton that adds to S the one displaces what adds to S the other, through the bridge, m/N.
fn moved(per_newton: [Pair; 2], one: Pair, other: Pair) -> f64 {
    dot(one, [dot(per_newton[0], other), dot(per_newton[1], other)])
}

/// The strings of one note, struck by one felt, and what lies on them.
#[derive(Debug, Clone)]
pub struct Strings {
    strings: Vec<PianoString>,
    bridge_modes: Vec<crate::instrument::BridgeMode>,
    /// What the bridge's modes send to two places ([`radiation`]), Pa s/m.
    radiated: Vec<Pair>,
    /// The bridge's modes in the order of their names.
    bridge_order: Vec<usize>,
    /// The hammer's, those of the dampers' felts, and the pedal's rail's.
    zones: Vec<usize>,
    /// The longest step that an impact is taken in, s.
    impact_step_s: f64,
    /// What is prepared, by the steps' length and their parts.
    prepared_for: (f64, Parts),
    /// For the parts that are not in use, where they have another length; whether those in use are the near ones.
    other: Option<Box<Prepared>>,
    near: bool,
    step_s: f64,
    blocks: Vec<Block>,
    /// The number of blocks whose modes move in the direction of the blow; the others move across it.
    vertical: usize,
    modes: Vec<Mode>,
    /// The dampers' felts, each on one string.
    felts: Vec<Felt>,
    /// What their dashpots do beside their forces in the next step.
    rocks: [Rocks; DASHPOTS],
    /// Where the bridge moves or strings move sideways: how these hang together. The bridge's mean displacement in the
    /// next step if nothing presses the strings, m.
    coupling: Coupling,
    drifts_m: Pair,
    /// How much smaller the compliance of two places is in the next step because dashpots are moved by it, m/N.
    held_m_per_n: Between,
    rail: Option<Rail>,
    /// Where it moves.
    bridge: Option<Bridge>,
    /// T/L of all strings, N/m.
    hold_n_per_m: f64,
    /// Between the places, m/N: the static compliance of the modes that are not stepped, of all modes together, and A
    /// of the step.
    beyond_m_per_n: Between,
    static_m_per_n: Between,
    compliance_m_per_n: Between,
    /// What a newton at each place adds to S in a step.
    sounds: [Pair; POINTS],
    /// By how much a newton at each place moves each dashpot in a step, m/N.
    rocked_m_per_n: [[f64; POINTS]; DASHPOTS],
    /// See [`Surfaces::follow`].
    statically: bool,
    /// What follows from the state: the hammer felt's displacement now and, undisturbed, a step later, m; S, the force
    /// on a bridge that stands still, N.
    now_m: f64,
    free_m: f64,
    sum_n: Pair,
    /// The last step's forces at the places, N.
    forces_n: [f64; POINTS],
    /// Those with which the action came to rest.
    resting_n: [f64; POINTS],
    /// What has been done to the strings so far, and what the pedal has done to the dampers, J.
    work_j: f64,
    given_j: f64,
    /// Of the former: what the strings have done to the bridge, and what rocked felts have taken, J.
    bridge_j: f64,
    rocked_j: f64,
    steps: u64,
    still: bool,
    /// How far each place swings at most while nothing touches the strings, m; infinite where that is not known.
    swings_m: [f64; POINTS],
}

impl Strings {
    /// The strings of an instrument, at rest; `None` where its string is rigid.
    #[must_use]
    pub(crate) fn of(instrument: &Instrument) -> Option<Self> {
        let zone = instrument.roles.string.filter(|_| instrument.has_yielding_strings())?;
        let felts = damping::felts(instrument);
        let mut zones = vec![zone];
        zones.extend(felts.iter().map(|felt| felt.zone));
        zones.extend(instrument.roles.pedal);
        let bridge_modes = if instrument.roles.rigid_bridge { Vec::new() } else { instrument.bridge_modes.clone() };
        let order: [usize; MAX_BRIDGE_MODES] = by_name(bridge_modes.iter().map(|mode| mode.name.as_str()));
        Some(Strings {
            strings: instrument.strings.clone(),
            radiated: radiation::BOARD.gains(&bridge_modes),
            bridge_order: order[..bridge_modes.len()].to_vec(),
            bridge_modes,
            zones,
            impact_step_s: parts::impact_step_s(instrument),
            prepared_for: (0.0, Parts::WHOLE),
            other: None,
            near: false,
            step_s: 0.0,
            blocks: Vec::new(),
            vertical: 0,
            modes: Vec::new(),
            felts,
            rocks: [Rocks::default(); DASHPOTS],
            coupling: [[0.0; DASHPOTS]; DASHPOTS],
            drifts_m: [0.0; 2],
            held_m_per_n: Between::default(),
            rail: instrument.roles.pedal.map(|_| Rail::default()),
            bridge: None,
            hold_n_per_m: instrument.strings.iter().map(|string| string.tension_n / string.length_m).sum(),
            beyond_m_per_n: Between::default(),
            static_m_per_n: Between::default(),
            compliance_m_per_n: Between::default(),
            sounds: [[0.0; 2]; POINTS],
            rocked_m_per_n: [[0.0; POINTS]; DASHPOTS],
            statically: false,
            now_m: 0.0,
            free_m: 0.0,
            sum_n: [0.0; 2],
            forces_n: [0.0; POINTS],
            resting_n: [0.0; POINTS],
            work_j: 0.0,
            given_j: 0.0,
            bridge_j: 0.0,
            rocked_j: 0.0,
            steps: 0,
            still: true,
            swings_m: [f64::INFINITY; POINTS],
        })
    }

    /// Those of a mechanism.
    #[must_use]
    pub fn under(mechanism: &dyn Mechanism) -> Option<&Self> {
        Strings::read(&mechanism.readout())
    }

    /// The strings of an instrument, from readings of the mechanism.
    pub(crate) fn read<'a>(now: &Readout<'a>) -> Option<&'a Self> {
        now.surfaces.and_then(|surfaces| surfaces.as_any().downcast_ref())
    }

    /// Everything still, as it stands under what lies on it when the action rests.
    pub(crate) fn reset_to_equilibrium(&mut self) {
        (self.forces_n, self.still) = (self.resting_n, true);
        self.stand();
    }

    /// The modes, at rest, with their exact steps of a length. Which ones there are does not depend on it.
    fn make_modes(&mut self, step_s: f64) {
        self.step_s = step_s;
        // First those in the direction of the blow, string by string, then those across it.
        let counts: [Vec<u32>; 2] = [
            self.strings.iter().map(PianoString::stepped).collect(),
            self.strings.iter().map(PianoString::stepped_sideways).collect(),
        ];
        let blocks_of = |direction: usize, string: usize| (counts[direction][string] as usize).div_ceil(WIDE);
        let all_of = |direction: usize| (0..counts[direction].len()).map(|string| blocks_of(direction, string)).sum();
        self.vertical = all_of(0);
        let horizontal: usize = all_of(1);
        let vertical = self.vertical;
        let first_of = |direction: usize, string: usize| {
            direction * vertical + (0..string).map(|string| blocks_of(direction, string)).sum::<usize>()
        };
        (self.modes, self.blocks) = (Vec::new(), vec![Block::default(); self.vertical + horizontal]);
        (self.beyond_m_per_n, self.static_m_per_n, self.compliance_m_per_n) =
            (Between::default(), Between::default(), Between::default());
        for felt in &mut self.felts {
            felt.lay([0, 1].map(|direction| (first_of(direction, felt.string), blocks_of(direction, felt.string))));
        }
        let moves = !self.bridge_modes.is_empty();
        let blocks = if moves { [self.vertical, horizontal] } else { [0; 2] };
        let mut bridge_rows = [Row::new(0, blocks[0]), Row::new(self.vertical, blocks[1])];
        let (mut bridge_n_per_m, mut answers_n_per_m) = ([self.hold_n_per_m; 2], [0.0; 2]);
        self.sounds = [[0.0; 2]; POINTS];
        let shares = self.shares();
        for (direction, counts) in counts.iter().enumerate() {
            for (index, string) in self.strings.iter().enumerate() {
                let (count, mass_kg) = (counts[index], string.modal_mass_kg());
                let share = shares[index] * string.strike_direction()[direction];
                let felt = self.felts.iter().position(|felt| felt.string == index);
                for n in 1..=count {
                    let omega = 2.0 * PI * string.partial_hz(n);
                    let shape = share * PianoString::shape(n, string.strike_m, string.length_m);
                    let stiffness_n_per_m = mass_kg * omega * omega;
                    let [qq, qv, vq, vv] = free_motion(string, n, step_s);
                    let rests = shape / stiffness_n_per_m;
                    let at = first_of(direction, index) * WIDE + (n - 1) as usize;
                    let (block, place) = (&mut self.blocks[at / WIDE], at % WIDE);
                    (block.qq[place], block.qv[place], block.vq[place], block.vv[place]) = (qq, qv, vq, vv);
                    (block.fq[place], block.fv[place]) = (rests * (1.0 - qq), -rests * vq);
                    block.shape[place] = shape;
                    let bridge = if string.partial_hz(n) < REACH_HZ { string.bridge_n_per_m(n) } else { 0.0 };
                    block.bridge[place] = bridge;
                    let mut shapes = [0.0; POINTS];
                    shapes[0] = shape;
                    match felt {
                        Some(k) if direction == 0 => {
                            let blocks = &self.blocks;
                            shapes[1 + k] = self.felts[k].set_mode(string, (n, shape), at, stiffness_n_per_m, blocks);
                        }
                        Some(k) => {
                            self.felts[k].set_side_mode(string, (n, shape), at, stiffness_n_per_m, &self.blocks);
                        }
                        None => {}
                    }
                    for (p, of_p) in shapes.iter().enumerate() {
                        for (other, of_other) in shapes.iter().enumerate() {
                            self.compliance_m_per_n[p][other] += of_p * (of_other / stiffness_n_per_m) * (1.0 - qq);
                            self.static_m_per_n[p][other] += of_p * (of_other / stiffness_n_per_m);
                        }
                        self.sounds[p][direction] += of_p * (bridge / stiffness_n_per_m) * (1.0 - qq);
                    }
                    if moves {
                        bridge_rows[direction].set(at, bridge, stiffness_n_per_m, &self.blocks);
                        bridge_n_per_m[direction] += bridge * bridge / stiffness_n_per_m;
                        answers_n_per_m[direction] += bridge * bridge / stiffness_n_per_m * (1.0 - qq);
                    }
                    self.modes.push(Mode { string: index, direction, n, at, mass_kg, stiffness_n_per_m });
                }
                // A string that does not move sideways has no compliance there.
                if direction == 1 && count == 0 {
                    continue;
                }
                self.beyond_m_per_n[0][0] += share * share * string.static_compliance_beyond(count);
                if let Some(k) = felt.filter(|_| direction == 0) {
                    let [own, with_hammer] = self.felts[k].beyond(string, count);
                    self.beyond_m_per_n[1 + k][1 + k] += own;
                    self.beyond_m_per_n[0][1 + k] += share * with_hammer;
                    self.beyond_m_per_n[1 + k][0] += share * with_hammer;
                }
            }
        }
        self.bridge =
            moves.then(|| Bridge::new(&self.bridge_modes, bridge_rows, bridge_n_per_m, answers_n_per_m, step_s));
        self.rocked_m_per_n = std::array::from_fn(|k| std::array::from_fn(|p| self.rocked_by(k, p)));
        let sounds_static: [Pair; POINTS] = std::array::from_fn(|p| self.sounds_statically(p));
        for p in 0..POINTS {
            for other in 0..POINTS {
                self.static_m_per_n[p][other] += self.beyond_m_per_n[p][other];
                self.compliance_m_per_n[p][other] += self.beyond_m_per_n[p][other];
                if let Some(bridge) = &self.bridge {
                    self.compliance_m_per_n[p][other] += moved(bridge.per_newton(), self.sounds[p], self.sounds[other]);
                    let stands_m = bridge.stands_m(sounds_static[other], self.hold_n_per_m);
                    self.static_m_per_n[p][other] += dot(sounds_static[p], stands_m);
                }
            }
        }
        self.update_surfaces();
    }

    /// The strings' shares of the hammer's force; their sum is one.
    fn shares(&self) -> [f64; MAX_STRINGS] {
        let all: f64 = self.strings.iter().map(|string| string.strike_share).sum();
        std::array::from_fn(|index| self.strings.get(index).map_or(0.0, |string| string.strike_share / all))
    }

    /// Whether dashpots and bridge are found together: the bridge moves, or a string moves sideways in its felts.
    fn is_joint(&self) -> bool {
        self.bridge.is_some() || self.vertical < self.blocks.len()
    }

    /// A mode's displacement at a place per metre of its own.
    fn shape(&self, point: usize, mode: &Mode) -> f64 {
        match point.checked_sub(1) {
            None => self.blocks[mode.at / WIDE].shape[mode.at % WIDE],
            Some(felt) => self.felts.get(felt).map_or(0.0, |felt| felt.row.shape(mode.at)),
        }
    }

    /// The part of a force at a place that stands on the bridge.
    fn sounds_statically(&self, point: usize) -> Pair {
        let bridge = |mode: &Mode| self.blocks[mode.at / WIDE].bridge[mode.at % WIDE];
        let of = |mode: &Mode| self.shape(point, mode) * bridge(mode) / mode.stiffness_n_per_m;
        [0, 1].map(|direction| self.modes.iter().filter(|mode| mode.direction == direction).map(of).sum())
    }

    /// What follows from where the modes are.
    fn update_surfaces(&mut self) {
        if let Some(bridge) = &mut self.bridge {
            bridge.look();
        }
        let free_n = self.sum_modes();
        self.couple(free_n);
    }

    /// The sums over all modes; returns S a step later if nothing presses the strings and the bridge stands still, N.
    fn sum_modes(&mut self) -> Pair {
        let ([mut now, mut free], [mut bridge, mut later]) = ([[0.0; WIDE]; 2], [[[0.0; WIDE]; 2]; 2]);
        for (direction, blocks) in <[_; 2]>::from(self.blocks.split_at(self.vertical)).into_iter().enumerate() {
            for block in blocks {
                let Block { q, v, qq, qv, shape, bridge: own, .. } = block;
                for i in 0..WIDE {
                    let after = qq[i] * q[i] + qv[i] * v[i];
                    now[i] += shape[i] * q[i];
                    free[i] += shape[i] * after;
                    bridge[direction][i] += own[i] * q[i];
                    later[direction][i] += own[i] * after;
                }
            }
        }
        self.set_sums(now, free, bridge);
        later.map(added)
    }

    /// What dashpots and bridge will do in the next step. `free_n`: of [`Strings::sum_modes`].
    fn couple(&mut self, free_n: Pair) {
        self.rocks = all_rocks(|k| match self.felts.get(k) {
            Some(felt) => felt.rocks(self.forces_n[1 + k], &self.blocks, self.step_s),
            None => Default::default(),
        });
        if self.is_joint() {
            let mut per_newton = [[0.0; 2]; 2];
            if let Some(bridge) = &self.bridge {
                self.drifts_m = bridge.mean_m(self.sum_n, free_n);
                per_newton = bridge.per_newton();
            }
            for (d, rocks) in self.rocks.iter_mut().enumerate().filter(|(_, rocks)| rocks.stiff_n_per_m > 0.0) {
                let (felt, kind) = felt_of(d);
                rocks.drift_m += dot(self.felts[felt].dashpots[kind].sounds, self.drifts_m);
            }
            self.coupling = coupling(&self.rocks, &self.felts, per_newton);
            self.held_m_per_n = self.held();
        }
    }

    #[inline(always)]
    fn set_sums(&mut self, now: [f64; WIDE], free: [f64; WIDE], bridge: [[f64; WIDE]; 2]) {
        (self.now_m, self.free_m, self.sum_n) = (added(now), added(free), bridge.map(added));
        for p in 0..=self.felts.len() {
            self.now_m += self.beyond_m_per_n[0][p] * self.forces_n[p];
        }
    }

    /// The modes' step under a force of the hammer, and what follows from where they are then.
    fn step_modes(&mut self, force_n: f64) {
        let ([mut now, mut free], mut bridge) = ([[0.0; WIDE]; 2], [[0.0; WIDE]; 2]);
        for (direction, blocks) in <[_; 2]>::from(self.blocks.split_at_mut(self.vertical)).into_iter().enumerate() {
            for block in blocks {
                let Block { q, v, qq, qv, vq, vv, fq, fv, shape, bridge: own } = block;
                for i in 0..WIDE {
                    let after = qq[i] * q[i] + qv[i] * v[i] + fq[i] * force_n;
                    v[i] = vq[i] * q[i] + vv[i] * v[i] + fv[i] * force_n;
                    q[i] = after;
                    now[i] += shape[i] * after;
                    free[i] += shape[i] * (qq[i] * after + qv[i] * v[i]);
                    bridge[direction][i] += own[i] * after;
                }
            }
        }
        self.set_sums(now, free, bridge);
    }

    /// The step of everything under the forces that are set.
    fn step_all(&mut self) {
        let pressed = self.forces_n[1..=self.felts.len()].iter().any(|force| *force != 0.0);
        let rocks = self.rocks;
        if !pressed && self.bridge.is_none() && rocks.iter().all(|rocks| rocks.stiff_n_per_m == 0.0) {
            self.step_modes(self.forces_n[0]);
            return;
        }
        if self.is_joint() {
            self.step_jointly();
            return;
        }
        let rocking: [Rocks; MAX_STRINGS] = std::array::from_fn(|felt| rocks[felt * (DASHPOTS / MAX_STRINGS)]);
        // What the felts' rocking was before.
        let rocked: [f64; MAX_STRINGS] = std::array::from_fn(|k| match self.felts.get(k) {
            Some(felt) if rocking[k].stiff_n_per_m > 0.0 => felt.dashpots[0].row.now(&self.blocks),
            _ => 0.0,
        });
        self.step_modes(self.forces_n[0]);
        self.press_felts();
        for (k, felt) in self.felts.iter().enumerate() {
            if rocking[k].stiff_n_per_m > 0.0 {
                self.rocked_j += felt.rock(&rocking[k], rocked[k], &mut self.blocks);
            }
        }
        self.update_surfaces();
    }

    /// What the forces of the dampers' felts have done to modes that have taken a step.
    fn press_felts(&mut self) {
        for (felt, &force_n) in self.felts.iter().zip(&self.forces_n[1..]) {
            if force_n != 0.0 {
                felt.row.press(force_n, &mut self.blocks);
            }
        }
    }

    /// The same step with a bridge that moves, or strings that move sideways: the bridge's mean displacement and the
    /// forces of the felts' dashpots are linear in the forces, which are all known now.
    fn step_jointly(&mut self) {
        let s_before_n = self.sum_n;
        let mut dashpots_n = [0.0; DASHPOTS];
        for (k, _) in self.rocking() {
            let way = |(l, rocks): (usize, &Rocks)| {
                let pressed: f64 = (0..POINTS).map(|p| self.rocked_m_per_n[l][p] * self.forces_n[p]).sum();
                self.coupling[k][l] * (rocks.drift_m + pressed)
            };
            dashpots_n[k] = -self.rocking().map(way).sum::<f64>();
        }
        let mut all_n = [0.0; 2];
        for (sounds, force_n) in self.sounds.iter().zip(&self.forces_n) {
            (all_n[0], all_n[1]) = (all_n[0] + sounds[0] * force_n, all_n[1] + sounds[1] * force_n);
        }
        for (k, _) in self.rocking() {
            let (felt, kind) = felt_of(k);
            let sounds = self.felts[felt].dashpots[kind].sounds;
            (all_n[0], all_n[1]) = (all_n[0] + sounds[0] * dashpots_n[k], all_n[1] + sounds[1] * dashpots_n[k]);
        }
        // The drift is the mean if nothing presses the strings.
        let mean_m = self.bridge.as_ref().map(|bridge| {
            let [vertical, horizontal] = bridge.per_newton();
            [self.drifts_m[0] + dot(vertical, all_n), self.drifts_m[1] + dot(horizontal, all_n)]
        });
        match (&self.bridge, mean_m) {
            (Some(bridge), Some(mean_m)) => {
                for (row, mean_m) in bridge.rows.iter().zip(mean_m) {
                    row.step(self.forces_n[0], mean_m, &mut self.blocks);
                }
            }
            _ => self.step_modes(self.forces_n[0]),
        }
        self.press_felts();
        for (k, (rocks, force_n)) in self.rocks.iter().zip(dashpots_n).enumerate() {
            if force_n != 0.0 {
                let (felt, kind) = felt_of(k);
                self.felts[felt].dashpots[kind].row.press(force_n, &mut self.blocks);
                self.rocked_j += force_n * force_n / rocks.per_s;
            }
        }
        let free_n = self.sum_modes();
        if let (Some(bridge), Some(mean_m)) = (&mut self.bridge, mean_m) {
            self.bridge_j += bridge.advance(bridge.mean_force_n([s_before_n, self.sum_n], mean_m));
        }
        self.couple(free_n);
    }

    /// What a place is displaced by now, m.
    fn point_now(&self, point: usize) -> f64 {
        match point.checked_sub(1) {
            None => self.now_m,
            Some(k) => {
                let beyond = |p: usize| self.beyond_m_per_n[point][p] * self.forces_n[p];
                self.felts[k].row.now(&self.blocks) + (0..POINTS).map(beyond).sum::<f64>()
            }
        }
    }

    /// The dashpots that move.
    fn rocking(&self) -> impl Iterator<Item = (usize, &Rocks)> {
        self.rocks.iter().enumerate().filter(|(_, rocks)| rocks.stiff_n_per_m > 0.0)
    }

    /// By how much a newton at a place moves a dashpot in a step, m/N.
    fn rocked_by(&self, dashpot: usize, point: usize) -> f64 {
        let (felt, kind) = felt_of(dashpot);
        let Some(dashpot) = self.felts.get(felt).and_then(|felt| felt.dashpots.get(kind)) else { return 0.0 };
        let [hammer, own] = dashpot.moved_by_m_per_n;
        let alone = match point {
            0 => hammer,
            _ if point == 1 + felt => own,
            _ => 0.0,
        };
        match &self.bridge {
            None => alone,
            Some(bridge) => alone + moved(bridge.per_newton(), dashpot.sounds, self.sounds[point]),
        }
    }

    /// How much smaller the compliance of two places is in a step because dashpots are moved by it, m/N; where these
    /// hang together.
    fn held(&self) -> Between {
        let mut held = Between::default();
        for (k, _) in self.rocking() {
            let mut gives = [0.0; POINTS];
            for (l, _) in self.rocking() {
                for (gives, rocked) in gives.iter_mut().zip(self.rocked_m_per_n[l]) {
                    *gives += self.coupling[k][l] * rocked;
                }
            }
            for (row, rocked) in held.iter_mut().zip(self.rocked_m_per_n[k]) {
                for (held, gives) in row.iter_mut().zip(gives) {
                    *held += rocked * gives;
                }
            }
        }
        held
    }

    /// Where a mode stands under the forces that are set, m. `bridge_m`: with the bridge there.
    fn rest_of(&self, mode: &Mode, bridge_m: Pair) -> f64 {
        let pressed: f64 = (0..=self.felts.len()).map(|p| self.shape(p, mode) * self.forces_n[p]).sum();
        let bridge = self.blocks[mode.at / WIDE].bridge[mode.at % WIDE] * bridge_m[mode.direction];
        (pressed + bridge) / mode.stiffness_n_per_m
    }

    /// Where the bridge stands under the forces that are set, m, and the strings' force on it then, N.
    fn bridge_stands(&self) -> [Pair; 2] {
        let Some(bridge) = &self.bridge else { return [[0.0; 2]; 2] };
        let mut pressed = [0.0; 2];
        for p in (0..=self.felts.len()).filter(|p| self.forces_n[*p] != 0.0) {
            let [vertical, horizontal] = self.sounds_statically(p);
            pressed[0] += vertical * self.forces_n[p];
            pressed[1] += horizontal * self.forces_n[p];
        }
        let stands_m = bridge.stands_m(pressed, self.hold_n_per_m);
        [stands_m, std::array::from_fn(|d| pressed[d] - self.hold_n_per_m * stands_m[d])]
    }

    /// Puts every mode where it rests under the forces that are set.
    fn stand(&mut self) {
        let [bridge_m, bridge_n] = self.bridge_stands();
        for i in 0..self.modes.len() {
            let mode = self.modes[i];
            let rest_m = self.rest_of(&mode, bridge_m);
            let block = &mut self.blocks[mode.at / WIDE];
            (block.q[mode.at % WIDE], block.v[mode.at % WIDE]) = (rest_m, 0.0);
        }
        if let Some(bridge) = &mut self.bridge {
            // Nothing is lost by being put somewhere.
            let before_j = bridge.own_energy_j();
            bridge.stand(bridge_n);
            self.bridge_j += bridge.own_energy_j() - before_j;
        }
        self.update_surfaces();
    }

    /// Whether what vibrates about the rest under the present forces is too little to count; single modes that do not
    /// are put to rest.
    #[cold]
    fn settle(&mut self) {
        let [bridge_m, bridge_n] = self.bridge_stands();
        let mut all_j = self.bridge.as_ref().map_or(0.0, |bridge| bridge.trembles_j(bridge_n));
        let mut stopped = false;
        for i in 0..self.modes.len() {
            let mode = self.modes[i];
            let rest = self.rest_of(&mode, bridge_m);
            let (block, place) = (&mut self.blocks[mode.at / WIDE], mode.at % WIDE);
            let (q, v) = (block.q[place] - rest, block.v[place]);
            let own_j = 0.5 * (mode.mass_kg * v * v + mode.stiffness_n_per_m * q * q);
            if own_j < MODE_STILL_J {
                stopped |= (block.q[place], block.v[place]) != (rest, 0.0);
                (block.q[place], block.v[place]) = (rest, 0.0);
            }
            all_j += own_j;
        }
        if all_j < STILL_J {
            self.still = true;
            self.stand();
        } else if stopped && self.is_joint() {
            // What the next step starts from is a function of the state, as a saved one has it.
            self.update_surfaces();
        }
    }
}
