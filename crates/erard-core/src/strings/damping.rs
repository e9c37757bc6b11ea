//! The dampers' felts on their strings.
//!
//! A damper's felt of length l lies on each string separately, so that it also damps strings of one note that move
//! against each other. Its compression is the mean along it, in Gauss's quadrature the mean of the two places
//! l/sqrt(12) before and behind its middle: this is a contact of the mechanism like any other, whose force depends on
//! the damper's weight on its lever, the key and the pedal.
//!
//! A partial with a node under the middle would not change that mean. It rocks the felt: half the difference of the two
//! places, r, is the additional compression of one end. Its force is the felt's own dashpot, c r' with c the loss of
//! the felt's law at the compression of the step before, c = b g^2 (a k g^r); found within the step, f = -c (r1 - r0) /
//! h with r1 = r_free + A_r f, so that it takes f^2 h / c, never less than nothing. (What the felt's stiffness adds to
//! that is left out.) It is linear in the forces of felt and hammer, r_free = r + sum A_rp F_p, and so the places yield
//! to these by a little less: by A_pr k A_rq with k = (c/h)/(1 + (c/h) A_r), and they are moved by -A_pr k (r - r0) if
//! nothing presses them.
//!
//! A string that also moves across the blow slides in its felt: the mean of the two places and half their difference
//! move two dashpots of the same c. (That the felt loses as much sideways as when it is compressed is an estimate.)
//!
//! Where the bridge moves, all felts of a note move each other's dashpots through it, and are moved by whatever presses
//! any of its strings: k is then the matrix (C^-1 + A)^-1 with C the dashpots c/h on its diagonal, and A what a newton
//! of one dashpot moves another by.

use moreau::gauss_jordan;

use super::bridge::{Pair, dot};
use super::rows::{Block, Row, WIDE};
use crate::instrument::{self, Curve, Instrument, MAX_STRINGS, PianoString};

/// Partials that a static compliance counts: the felt's length makes it converge soon.
const STATIC_PARTIALS: u32 = 400;
/// sqrt(12), for Gauss's two places.
const GAUSS: f64 = 3.464_101_615_137_754_6;
/// Dashpots of a felt: that of its rocking, and two of a string that slides in it.
const KINDS: usize = 3;
/// Dashpots of all felts of a note.
pub(super) const DASHPOTS: usize = KINDS * MAX_STRINGS;

/// One felt on one string.
#[derive(Debug, Clone)]
pub(super) struct Felt {
    pub zone: usize,
    pub string: usize,
    law: instrument::Felt,
    /// 1 where it pushes the string the way the hammer does, -1 against it, as a damper above strings that are struck
    /// from below.
    side: f64,
    /// Gauss's two places, m.
    places_m: [f64; 2],
    /// Its mean.
    pub row: Row,
    /// Rocking; and of a string that moves sideways, its mean and half the difference of the ends.
    pub dashpots: Vec<Dashpot>,
    /// By how much in a step a newton of one dashpot moves another, m/N.
    between_m_per_n: [[f64; KINDS]; KINDS],
}

/// What a dashpot of a felt is moved by.
#[derive(Debug, Clone, Default)]
pub(super) struct Dashpot {
    /// What moves it: of the rocking half the difference of the felt's ends.
    pub row: Row,
    /// How far in a step a newton on the hammer and on the felt moves it, and the other way round, m/N.
    pub moved_by_m_per_n: [f64; 2],
    /// Change of S in a step by its newton.
    pub sounds: Pair,
}

impl Dashpot {
    /// Takes in a mode of its string in a direction (0 that of the blow, 1 across it), which displaces the dashpot and
    /// the hammer by so much per metre. Returns how far in a step a newton on the dashpot moves the mode, m/N.
    fn set_mode(
        &mut self,
        [shape, hammer]: [f64; 2],
        at: usize,
        stiffness_n_per_m: f64,
        blocks: &[Block],
        direction: usize,
    ) -> f64 {
        let Block { qq, bridge, .. } = &blocks[at / WIDE];
        self.row.set(at, shape, stiffness_n_per_m, blocks);
        let moves = shape / stiffness_n_per_m * (1.0 - qq[at % WIDE]);
        self.moved_by_m_per_n[0] += hammer * moves;
        self.sounds[direction] += bridge[at % WIDE] * moves;
        moves
    }
}

/// Those of an instrument.
pub(super) fn felts(instrument: &Instrument) -> Vec<Felt> {
    let of = |(string, one): (usize, &PianoString)| {
        let damper = one.damper?;
        let half_m = damper.length_m / GAUSS;
        Some(Felt {
            zone: damper.zone,
            string,
            side: side(instrument, damper.zone),
            law: instrument.zones[damper.zone].felt,
            places_m: [damper.middle_m - half_m, damper.middle_m + half_m],
            row: Row::default(),
            dashpots: Vec::new(),
            between_m_per_n: [[0.0; KINDS]; KINDS],
        })
    };
    instrument.strings.iter().enumerate().filter_map(of).collect()
}

/// On which side of the strings a damper lies: both curves are where the strings are at rest, with normals toward what
/// presses.
fn side(instrument: &Instrument, damper: usize) -> f64 {
    let normal = |zone: usize| match instrument.zones[zone].curve {
        Curve::Line { normal, .. } => normal,
        _ => [0.0; 2],
    };
    let ([x, y], [u, v]) = (normal(damper), instrument.roles.string.map_or([0.0; 2], normal));
    if x * u + y * v < 0.0 { -1.0 } else { 1.0 }
}

impl Felt {
    /// Its string has these blocks (first, count) in each direction; without the second it does not move sideways.
    pub(crate) fn lay(&mut self, [vertical, horizontal]: [(usize, usize); 2]) {
        let dashpot = |(first, blocks): (usize, usize)| Dashpot { row: Row::new(first, blocks), ..Dashpot::default() };
        self.row = Row::new(vertical.0, vertical.1);
        self.dashpots = vec![dashpot(vertical)];
        if horizontal.1 > 0 {
            self.dashpots.extend([dashpot(horizontal), dashpot(horizontal)]);
        }
        self.between_m_per_n = [[0.0; KINDS]; KINDS];
    }

    /// A mode's displacement of the felt, away from it, and of its rocking, per metre.
    fn shapes(&self, string: &PianoString, n: u32) -> [f64; 2] {
        let [a, b] = self.places_m.map(|place_m| PianoString::shape(n, place_m, string.length_m));
        [self.side * 0.5 * (a + b), self.side * 0.5 * (b - a)]
    }

    /// Takes in a mode of its string, which displaces the hammer by so much per metre; returns its displacement of the
    /// felt.
    pub(crate) fn set_mode(
        &mut self,
        string: &PianoString,
        (n, hammer): (u32, f64),
        at: usize,
        stiffness_n_per_m: f64,
        blocks: &[Block],
    ) -> f64 {
        let [mean, half] = self.shapes(string, n);
        self.row.set(at, mean, stiffness_n_per_m, blocks);
        let rocking = &mut self.dashpots[0];
        let rocks = rocking.set_mode([half, hammer], at, stiffness_n_per_m, blocks, 0);
        self.between_m_per_n[0][0] += half * rocks;
        rocking.moved_by_m_per_n[1] += mean * rocks;
        mean
    }

    /// Takes in a mode of its string across the blow.
    pub(crate) fn set_side_mode(
        &mut self,
        string: &PianoString,
        (n, hammer): (u32, f64),
        at: usize,
        stiffness_n_per_m: f64,
        blocks: &[Block],
    ) {
        let shapes = self.shapes(string, n);
        for (k, of_k) in shapes.into_iter().enumerate() {
            let moves = self.dashpots[1 + k].set_mode([of_k, hammer], at, stiffness_n_per_m, blocks, 1);
            for (l, of_l) in shapes.into_iter().enumerate() {
                self.between_m_per_n[1 + k][1 + l] += of_l * moves;
            }
        }
    }

    /// Static compliances of the modes beyond the first so many, m/N: its own, and with a hammer that strikes this
    /// string alone.
    pub(crate) fn beyond(&self, string: &PianoString, count: u32) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for n in (count + 1..=STATIC_PARTIALS.max(count + 1)).rev() {
            let [mean, _] = self.shapes(string, n);
            let omega = 2.0 * std::f64::consts::PI * string.partial_hz(n);
            let gives = mean / (string.modal_mass_kg() * omega * omega);
            sums[0] += mean * gives;
            sums[1] += PianoString::shape(n, string.strike_m, string.length_m) * gives;
        }
        sums
    }

    /// The loss of the felt's law where it is pressed so, N s/m.
    fn dashpot(&self, force_n: f64) -> f64 {
        if force_n <= 0.0 || self.law.stiffness <= 0.0 {
            return 0.0;
        }
        let g = libm::pow(force_n / self.law.stiffness, 1.0 / self.law.exponent);
        self.law.loss.viscous(g, force_n)
    }

    /// What its dashpots do in the next step, after one under this force.
    pub(crate) fn rocks(&self, force_n: f64, blocks: &[Block], step_s: f64) -> [Rocks; KINDS] {
        let per_s = self.dashpot(force_n) / step_s;
        if per_s <= 0.0 {
            return [Rocks::default(); KINDS];
        }
        std::array::from_fn(|kind| {
            let Some(dashpot) = self.dashpots.get(kind) else { return Rocks::default() };
            let stiff_n_per_m = per_s / (1.0 + per_s * self.between_m_per_n[kind][kind]);
            Rocks { per_s, stiff_n_per_m, drift_m: dashpot.row.free(blocks) - dashpot.row.now(blocks) }
        })
    }

    /// After a step under the other forces: what the rocking has taken meanwhile, J. `before_m`: where it was.
    pub(crate) fn rock(&self, rocks: &Rocks, before_m: f64, blocks: &mut [Block]) -> f64 {
        let rocking = &self.dashpots[0].row;
        let force_n = -rocks.stiff_n_per_m * (rocking.now(blocks) - before_m);
        rocking.press(force_n, blocks);
        force_n * force_n / rocks.per_s
    }
}

/// A dashpot of a felt in a step. All zero: the felt is not pressed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rocks {
    /// c/h, N/m.
    pub per_s: f64,
    /// (c/h) / (1 + (c/h) A_r): its force per metre by which it would move if it did nothing, N/m.
    pub stiff_n_per_m: f64,
    /// By how much it moves if nothing presses it, m.
    pub drift_m: f64,
}

/// A dashpot's felt, and which of the felt's it is.
pub(super) fn felt_of(dashpot: usize) -> (usize, usize) {
    (dashpot / KINDS, dashpot % KINDS)
}

/// The dashpots of all felts in the next step, by what computes those of a felt.
pub(super) fn all_rocks(of: impl Fn(usize) -> [Rocks; KINDS]) -> [Rocks; DASHPOTS] {
    let mut all = [Rocks::default(); DASHPOTS];
    for felt in 0..MAX_STRINGS {
        all[felt * KINDS..][..KINDS].copy_from_slice(&of(felt));
    }
    all
}

/// A number for every two dashpots.
pub(super) type Coupling = [[f64; DASHPOTS]; DASHPOTS];

/// How dashpots that move hang together where the bridge moves or strings move sideways, (C^-1 + A)^-1, N/m: what a
/// metre by which one would move makes another push. `per_newton` is the bridge's.
pub(super) fn coupling(rocks: &[Rocks; DASHPOTS], felts: &[Felt], per_newton: [Pair; 2]) -> Coupling {
    let mut moved = [0; DASHPOTS];
    let mut count = 0;
    for (dashpot, _) in rocks.iter().enumerate().filter(|(_, rocks)| rocks.per_s > 0.0) {
        (moved[count], count) = (dashpot, count + 1);
    }
    let moved = &moved[..count];
    if count <= MAX_STRINGS {
        inverse::<MAX_STRINGS>(moved, rocks, felts, per_newton)
    } else {
        inverse::<DASHPOTS>(moved, rocks, felts, per_newton)
    }
}

/// C^-1 + A of the dashpots that move, inverted: symmetric and positive, so that no pivot is missing.
fn inverse<const K: usize>(
    moved: &[usize],
    rocks: &[Rocks; DASHPOTS],
    felts: &[Felt],
    per_newton: [Pair; 2],
) -> Coupling {
    let mut coupling = [[0.0; DASHPOTS]; DASHPOTS];
    if moved.is_empty() {
        return coupling;
    }
    let (mut matrix, mut inverse) = ([[0.0; K]; K], [[0.0; K]; K]);
    for i in 0..K {
        (matrix[i][i], inverse[i][i]) = (1.0, 1.0);
    }
    for (i, &a) in moved.iter().enumerate() {
        let (felt, kind) = felt_of(a);
        let sounds = felts[felt].dashpots[kind].sounds;
        for (j, &b) in moved.iter().enumerate() {
            let (other, other_kind) = felt_of(b);
            let across = felts[other].dashpots[other_kind].sounds;
            matrix[i][j] = dot(sounds, [dot(per_newton[0], across), dot(per_newton[1], across)]);
            if felt == other {
                matrix[i][j] += felts[felt].between_m_per_n[kind][other_kind];
            }
        }
        matrix[i][i] += 1.0 / rocks[a].per_s;
    }
    gauss_jordan(&mut matrix, &mut inverse);
    for (i, &a) in moved.iter().enumerate() {
        for (j, &b) in moved.iter().enumerate() {
            coupling[a][b] = inverse[i][j];
        }
    }
    coupling
}
