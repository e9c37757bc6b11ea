//! The strings of a note in their modes: what the engine asks of a surface that yields.

use core::f64::consts::PI;
use std::any::Any;

use moreau::Surface;
use moreau_sizes::{Mechanism, Surfaces};

use super::tuning::REACH_HZ;
use crate::instrument::{Instrument, PianoString};

/// Modes that are stepped side by side. The compiler makes vectors of four; the order of sums is fixed, so that the bits are the same on every target.
const WIDE: usize = 4;
/// Every so many steps it is seen whether the strings have come to rest.
const LOOK_EVERY: u64 = 64;
/// J; strings whose vibration holds less than this are still. A pianissimo puts 1e-3 J into them: 150 dB less. Decaying for ever, they would end in
/// numbers that are slow to compute with (denormal ones).
const STILL_J: f64 = 1e-18;
/// J; likewise for a single mode among others.
const MODE_STILL_J: f64 = 1e-30;

/// [`WIDE`] modes. Places beyond the last mode are zero.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    /// Displacement, m, and velocity, m/s.
    q: [f64; WIDE],
    v: [f64; WIDE],
    /// The exact step of a free mode: (q, v) -> (qq q + qv v, vq q + vv v).
    qq: [f64; WIDE],
    qv: [f64; WIDE],
    vq: [f64; WIDE],
    vv: [f64; WIDE],
    /// What a newton on the felt that lasts for the step adds to q, m, and to v, m/s.
    fq: [f64; WIDE],
    fv: [f64; WIDE],
    /// Its part of the felt's displacement per metre, with the string's share of the felt.
    shape: [f64; WIDE],
    /// Its part of the bridge force, N/m.
    bridge: [f64; WIDE],
}

/// What is seldom needed of a mode.
#[derive(Debug, Clone, Copy)]
struct Mode {
    string: usize,
    n: u32,
    mass_kg: f64,
    /// m omega^2, N/m.
    stiffness_n_m: f64,
}

/// The strings of one note, struck by one felt.
#[derive(Debug, Clone)]
pub struct Strings {
    strings: Vec<PianoString>,
    zones: [usize; 1],
    step_s: f64,
    blocks: Vec<Block>,
    modes: Vec<Mode>,
    /// Static compliance of the modes that are not stepped, of all modes together; and A of the step, m/N.
    beyond_m_n: f64,
    static_m_n: f64,
    compliance_m_n: f64,
    /// See [`Surfaces::follow`].
    statically: bool,
    /// What follows from the state: the felt's displacement now and, undisturbed, a step later, m; the force on the bridge, N.
    now_m: f64,
    free_m: f64,
    bridge_n: f64,
    /// The last step's force, N.
    force_n: f64,
    /// What the felt has done to the strings so far, J.
    work_j: f64,
    steps: u64,
    still: bool,
}

impl Strings {
    /// The strings of an instrument, at rest; `None` where its string is rigid.
    #[must_use]
    pub fn of(instrument: &Instrument, step_s: f64) -> Option<Self> {
        let zone = instrument.roles.string.filter(|_| instrument.has_yielding_strings())?;
        let mut strings = Strings {
            strings: instrument.strings.clone(),
            zones: [zone],
            step_s: 0.0,
            blocks: Vec::new(),
            modes: Vec::new(),
            beyond_m_n: 0.0,
            static_m_n: 0.0,
            compliance_m_n: 0.0,
            statically: false,
            now_m: 0.0,
            free_m: 0.0,
            bridge_n: 0.0,
            force_n: 0.0,
            work_j: 0.0,
            steps: 0,
            still: true,
        };
        strings.make_modes(step_s);
        Some(strings)
    }

    /// Those of a mechanism.
    #[must_use]
    pub fn under(mechanism: &dyn Mechanism) -> Option<&Self> {
        mechanism.surfaces().and_then(|surfaces| surfaces.as_any().downcast_ref())
    }

    /// The strings.
    #[must_use]
    pub fn strings(&self) -> &[PianoString] {
        &self.strings
    }

    /// How many modes are stepped.
    #[must_use]
    pub fn modes(&self) -> usize {
        self.modes.len()
    }

    /// Displacement under the felt now, m, away from the hammer; of several strings their mean.
    #[must_use]
    pub fn displacement_m(&self) -> f64 {
        self.now_m
    }

    /// Force of all strings on the bridge now, N, in the direction in which the hammer pushes them; of the modes that are stepped.
    #[must_use]
    pub fn bridge_n(&self) -> f64 {
        self.bridge_n
    }

    /// A string's displacement at a place now, m, of the modes that are stepped; `place_m` from the end that the strike is counted from.
    ///
    /// # Panics
    /// If there is no such string.
    #[must_use]
    pub fn shape_m(&self, string: usize, place_m: f64) -> f64 {
        let length_m = self.strings[string].length_m;
        let own = self.modes.iter().enumerate().filter(|(_, mode)| mode.string == string);
        own.map(|(i, mode)| PianoString::shape(mode.n, place_m, length_m) * self.blocks[i / WIDE].q[i % WIDE]).sum()
    }

    /// Everything at rest, undisplaced.
    pub fn hush(&mut self) {
        for block in &mut self.blocks {
            (block.q, block.v) = ([0.0; WIDE], [0.0; WIDE]);
        }
        (self.force_n, self.still) = (0.0, true);
        self.look();
    }

    /// The modes that a step of this length reaches, at rest, with their exact steps.
    fn make_modes(&mut self, step_s: f64) {
        self.step_s = step_s;
        let reach_hz = REACH_HZ.min(0.5 / step_s);
        let share = 1.0 / self.strings.len() as f64;
        let (mut modes, mut blocks) = (Vec::new(), Vec::new());
        (self.beyond_m_n, self.static_m_n, self.compliance_m_n) = (0.0, 0.0, 0.0);
        for (index, string) in self.strings.iter().enumerate() {
            let count = string.partials_below(reach_hz);
            let mass_kg = string.modal_mass_kg();
            for n in 1..=count {
                let (omega, sigma) = (2.0 * PI * string.partial_hz(n), string.decay_per_s(n));
                let shape = share * PianoString::shape(n, string.strike_m, string.length_m);
                let stiffness_n_m = mass_kg * omega * omega;
                let [qq, qv, vq, vv] = transition(omega, sigma, step_s);
                let rests = shape / stiffness_n_m;
                let place = modes.len() % WIDE;
                if place == 0 {
                    blocks.push(Block::default());
                }
                if let Some(block) = blocks.last_mut() {
                    (block.qq[place], block.qv[place], block.vq[place], block.vv[place]) = (qq, qv, vq, vv);
                    (block.fq[place], block.fv[place]) = (rests * (1.0 - qq), -rests * vq);
                    block.shape[place] = shape;
                    block.bridge[place] = string.bridge_n_m(n);
                }
                self.compliance_m_n += shape * rests * (1.0 - qq);
                self.static_m_n += shape * rests;
                modes.push(Mode { string: index, n, mass_kg, stiffness_n_m });
            }
            self.beyond_m_n += share * share * string.static_compliance_beyond(count);
        }
        self.static_m_n += self.beyond_m_n;
        self.compliance_m_n += self.beyond_m_n;
        (self.blocks, self.modes) = (blocks, modes);
        self.look();
    }

    /// What follows from where the modes are.
    fn look(&mut self) {
        let [mut now, mut free, mut bridge] = [[0.0; WIDE]; 3];
        for block in &self.blocks {
            let Block { q, v, qq, qv, shape, bridge: own, .. } = block;
            for i in 0..WIDE {
                now[i] += shape[i] * q[i];
                free[i] += shape[i] * (qq[i] * q[i] + qv[i] * v[i]);
                bridge[i] += own[i] * q[i];
            }
        }
        self.set_sums(now, free, bridge);
    }

    #[inline(always)]
    fn set_sums(&mut self, now: [f64; WIDE], free: [f64; WIDE], bridge: [f64; WIDE]) {
        let sum = |x: [f64; WIDE]| (x[0] + x[1]) + (x[2] + x[3]);
        self.now_m = sum(now) + self.beyond_m_n * self.force_n;
        (self.free_m, self.bridge_n) = (sum(free), sum(bridge));
    }

    /// The modes' step under a force, and what follows from where they are then.
    fn step_modes(&mut self, force_n: f64) {
        let [mut now, mut free, mut bridge] = [[0.0; WIDE]; 3];
        for block in &mut self.blocks {
            let Block { q, v, qq, qv, vq, vv, fq, fv, shape, bridge: own } = block;
            for i in 0..WIDE {
                let after = qq[i] * q[i] + qv[i] * v[i] + fq[i] * force_n;
                v[i] = vq[i] * q[i] + vv[i] * v[i] + fv[i] * force_n;
                q[i] = after;
                now[i] += shape[i] * after;
                free[i] += shape[i] * (qq[i] * after + qv[i] * v[i]);
                bridge[i] += own[i] * after;
            }
        }
        self.force_n = force_n;
        self.set_sums(now, free, bridge);
    }

    /// Puts every mode where it rests under a force.
    fn stand(&mut self, force_n: f64) {
        for (i, mode) in self.modes.iter().enumerate() {
            let (block, place) = (&mut self.blocks[i / WIDE], i % WIDE);
            block.q[place] = block.shape[place] * force_n / mode.stiffness_n_m;
            block.v[place] = 0.0;
        }
        self.force_n = force_n;
        self.look();
    }

    /// Whether what vibrates about the rest under the present force is too little to count; single modes that do not are put to rest.
    #[cold]
    fn settle(&mut self) {
        let mut all_j = 0.0;
        for (i, mode) in self.modes.iter().enumerate() {
            let (block, place) = (&mut self.blocks[i / WIDE], i % WIDE);
            let rest = block.shape[place] * self.force_n / mode.stiffness_n_m;
            let (q, v) = (block.q[place] - rest, block.v[place]);
            let own_j = 0.5 * (mode.mass_kg * v * v + mode.stiffness_n_m * q * q);
            if own_j < MODE_STILL_J {
                (block.q[place], block.v[place]) = (rest, 0.0);
            }
            all_j += own_j;
        }
        if all_j < STILL_J {
            self.still = true;
            self.stand(self.force_n);
        }
    }

    /// Energy of the modes and of what follows statically, J.
    fn energy_j(&self) -> f64 {
        let modes: f64 = self
            .modes
            .iter()
            .enumerate()
            .map(|(i, mode)| {
                let (q, v) = (self.blocks[i / WIDE].q[i % WIDE], self.blocks[i / WIDE].v[i % WIDE]);
                0.5 * (mode.mass_kg * v * v + mode.stiffness_n_m * q * q)
            })
            .sum();
        modes + 0.5 * self.beyond_m_n * self.force_n * self.force_n
    }
}

/// The exact step of length h of a free mode: (q, v) -> (qq q + qv v, vq q + vv v). An overdamped one, too.
fn transition(omega: f64, sigma: f64, h: f64) -> [f64; 4] {
    let square = omega * omega - sigma * sigma;
    let decay = libm::exp(-sigma * h);
    let (c, s) = if square > 0.0 {
        let w = square.sqrt();
        (libm::cos(w * h), libm::sin(w * h) / w)
    } else if square < 0.0 {
        let w = (-square).sqrt();
        (libm::cosh(w * h), libm::sinh(w * h) / w)
    } else {
        (1.0, h)
    };
    [decay * (c + sigma * s), decay * s, -decay * omega * omega * s, decay * (c - sigma * s)]
}

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
        self.make_modes(step_s);
        // Modes that both reach go on as they were.
        for (i, mode) in modes.iter().enumerate() {
            let same = self.modes.iter().position(|other| (other.string, other.n) == (mode.string, mode.n));
            if let Some(k) = same {
                self.blocks[k / WIDE].q[k % WIDE] = before[i / WIDE].q[i % WIDE];
                self.blocks[k / WIDE].v[k % WIDE] = before[i / WIDE].v[i % WIDE];
            }
        }
        if self.still {
            self.stand(self.force_n);
        } else {
            self.look();
        }
    }

    fn follow(&mut self, statically: bool) {
        if statically && !self.statically {
            self.stand(self.force_n);
            self.still = true;
        }
        self.statically = statically;
    }

    fn surface(&self, _: usize) -> Surface<f64> {
        if self.statically {
            return Surface { displacement: self.now_m, free: 0.0, compliance: self.static_m_n };
        }
        Surface { displacement: self.now_m, free: self.free_m, compliance: self.compliance_m_n }
    }

    fn advance(&mut self, forces: &[f64]) {
        let force_n = forces[0];
        if self.still && force_n.to_bits() == self.force_n.to_bits() {
            return;
        }
        let before_m = self.now_m;
        if self.statically {
            self.stand(force_n);
        } else {
            self.still = false;
            self.step_modes(force_n);
            self.steps += 1;
            if self.steps.is_multiple_of(LOOK_EVERY) {
                self.settle();
            }
        }
        self.work_j += force_n * (self.now_m - before_m);
    }

    fn rests(&self) -> bool {
        self.still
    }

    fn energy(&self) -> f64 {
        self.energy_j()
    }

    fn lost(&self) -> f64 {
        self.work_j - self.energy_j()
    }

    fn numbers(&self) -> usize {
        2 * self.modes.len() + 4
    }

    fn save(&self, put: &mut dyn FnMut(f64)) {
        for i in 0..self.modes.len() {
            put(self.blocks[i / WIDE].q[i % WIDE]);
            put(self.blocks[i / WIDE].v[i % WIDE]);
        }
        put(self.force_n);
        put(self.work_j);
        put((self.steps % LOOK_EVERY) as f64);
        put(f64::from(u8::from(self.still)));
    }

    fn restore(&mut self, from: &[f64]) {
        if from.len() != self.numbers() {
            self.hush();
            self.work_j = 0.0;
            self.steps = 0;
            return;
        }
        for i in 0..self.modes.len() {
            (self.blocks[i / WIDE].q[i % WIDE], self.blocks[i / WIDE].v[i % WIDE]) = (from[2 * i], from[2 * i + 1]);
        }
        let rest = &from[2 * self.modes.len()..];
        (self.force_n, self.work_j, self.steps, self.still) = (rest[0], rest[1], rest[2] as u64, rest[3] != 0.0);
        self.look();
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
