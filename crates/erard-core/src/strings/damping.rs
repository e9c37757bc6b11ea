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
//! Where the bridge moves, all felts of a note rock each other through it, and are rocked by whatever presses any of
//! its strings: k is then the matrix (C^-1 + A)^-1 with C the dashpots c/h on its diagonal, and A what a newton that
//! rocks one felt rocks another by.

use moreau::gauss_jordan;

use super::rows::{Block, Row, WIDE};
use crate::instrument::{self, Curve, Instrument, MAX_STRINGS, PianoString};

/// Partials that a static compliance counts: the felt's length makes it converge soon.
const STATIC_PARTIALS: u32 = 400;
/// sqrt(12), for Gauss's two places.
const GAUSS: f64 = 3.464_101_615_137_754_6;

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
    /// Its mean, and half the difference of its ends.
    pub row: Row,
    pub rocking: Row,
    /// A of the rocking, m/N; and how far in a step a newton on the hammer and on the felt itself rocks it, and the
    /// other way round, m/N.
    rocks_m_per_n: f64,
    pub rocked_by_m_per_n: [f64; 2],
    /// Change of S in a step by a newton that rocks it.
    pub rocking_sounds: f64,
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
            rocking: Row::default(),
            rocks_m_per_n: 0.0,
            rocked_by_m_per_n: [0.0; 2],
            rocking_sounds: 0.0,
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
    /// Its string has these blocks.
    pub(crate) fn lay(&mut self, first: usize, blocks: usize) {
        (self.row, self.rocking) = (Row::new(first, blocks), Row::new(first, blocks));
        (self.rocks_m_per_n, self.rocked_by_m_per_n, self.rocking_sounds) = (0.0, [0.0; 2], 0.0);
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
        let Block { qq, bridge, .. } = &blocks[at / WIDE];
        let (qq, bridge) = (qq[at % WIDE], bridge[at % WIDE]);
        self.row.set(at, mean, stiffness_n_per_m, blocks);
        self.rocking.set(at, half, stiffness_n_per_m, blocks);
        let rocks = half / stiffness_n_per_m * (1.0 - qq);
        self.rocks_m_per_n += half * rocks;
        self.rocked_by_m_per_n[0] += hammer * rocks;
        self.rocked_by_m_per_n[1] += mean * rocks;
        self.rocking_sounds += bridge * rocks;
        mean
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

    /// What its rocking does in the next step, after one under this force.
    pub(crate) fn rocks(&self, force_n: f64, blocks: &[Block], step_s: f64) -> Rocks {
        let per_s = self.dashpot(force_n) / step_s;
        if per_s <= 0.0 {
            return Rocks::default();
        }
        let stiff_n_per_m = per_s / (1.0 + per_s * self.rocks_m_per_n);
        Rocks { per_s, stiff_n_per_m, drift_m: self.rocking.free(blocks) - self.rocking.now(blocks) }
    }

    /// After a step under the other forces: what the rocking has taken meanwhile, J. `before_m`: where it was.
    pub(crate) fn rock(&self, rocks: &Rocks, before_m: f64, blocks: &mut [Block]) -> f64 {
        let force_n = -rocks.stiff_n_per_m * (self.rocking.now(blocks) - before_m);
        self.rocking.press(force_n, blocks);
        force_n * force_n / rocks.per_s
    }

    /// By how much a newton that rocks it rocks it in a step, m/N.
    pub(crate) fn rocks_m_per_n(&self) -> f64 {
        self.rocks_m_per_n
    }
}

/// The rocking of a felt in a step. All zero: it is not pressed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rocks {
    /// c/h, N/m.
    pub per_s: f64,
    /// (c/h) / (1 + (c/h) A_r): its force per metre by which it would rock if its dashpot did nothing, N/m.
    pub stiff_n_per_m: f64,
    /// By how much it rocks if nothing presses it, m.
    pub drift_m: f64,
}

/// A number for every two felts that rock.
pub(super) type BridgeCoupling = [[f64; MAX_STRINGS]; MAX_STRINGS];

/// How felts that rock hang together where the bridge moves, (C^-1 + A)^-1, N/m: what a metre by which one would rock
/// makes another's dashpot push. `per_newton` is the bridge's.
pub(super) fn bridge_coupling(rocks: &[Rocks; MAX_STRINGS], felts: &[Felt], per_newton: f64) -> BridgeCoupling {
    let rocked: [bool; MAX_STRINGS] = std::array::from_fn(|k| rocks[k].per_s > 0.0);
    // C^-1 + A and a one for each felt, among those that rock: symmetric and positive, so that no pivot is missing.
    let (mut matrix, mut inverse) = (BridgeCoupling::default(), BridgeCoupling::default());
    for k in 0..MAX_STRINGS {
        if !rocked[k] {
            matrix[k][k] = 1.0;
            continue;
        }
        for (l, felt) in felts.iter().enumerate().filter(|(l, _)| rocked[*l]) {
            matrix[k][l] = felts[k].rocking_sounds * per_newton * felt.rocking_sounds;
        }
        matrix[k][k] += 1.0 / rocks[k].per_s + felts[k].rocks_m_per_n();
        inverse[k][k] = 1.0;
    }
    gauss_jordan(&mut matrix, &mut inverse);
    inverse
}
