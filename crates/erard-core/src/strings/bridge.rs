//! A bridge that moves: modes of the soundboard at the place where the strings of a note end, which all of them drive
//! and which moves them all, in the direction of the blow ("vertical") and across it ("horizontal").
//!
//! **A mode has a direction.** Mode k displaces the bridge by d_k r_k with d_k = (1, c_k): it moves the strings' ends
//! horizontally by c_k per metre of vertical motion, as a bridge does that rocks on the bending board and pins that
//! stand askew. The admittance is, (S5) of the book,
//!
//! ```text
//! Y(omega) = sum i omega d_k d_k^T / (M_k (omega_k^2 - omega^2 + i eta_k omega_k omega))
//! ```
//!
//! Each residue d_k d_k^T / M_k is positive semidefinite, so that Re Y is, too: whatever the two directions exchange,
//! the bridge takes energy and gives none.
//!
//! **Energy.** Where the bridge is displaced by w, a string without inertia hangs straight, u = w x/L. In the string's
//! modes that is beta_n w with beta_n = b_n / (m omega_n^2), b_n being the mode's force on the bridge per metre. The
//! strings' potential energy is that of what they bend away from there, in each direction
//!
//! ```text
//! V = sum m omega_n^2 (q_n - beta_n w)^2 / 2 + (T/L) w^2 / 2      (never negative)
//! ```
//!
//! so that mode n feels the force b_n w, and the bridge F_b = S - K w with S = sum b_n q_n and K = sum b_n beta_n +
//! T/L, (S3) of the book: what acts one way acts the other way with the same number. The bridge's own modes are
//! oscillators with M_k r_k'' + ... = d_k . F_b and w = sum d_k r_k.
//!
//! **A step.** The strings' modes move exactly under the mean w of the step's two ends, those of the bridge exactly
//! under the mean F_b. The work that the one does, w . (S1 - S0), and that of the other, F_b . (w1 - w0), add up to
//! what V has changed by, whatever the length of the step: no energy is gained, and nothing can become unstable. With
//! G = sum d_k d_k^T (1 - P_11) / k_k, what a newton adds to w in a step, and A_d = sum b_n^2 (1 - P_11) / (m
//! omega_n^2), what a metre adds to S in direction d, the mean w solves
//!
//! ```text
//! (2 + G (K - A/2)) w = w0 + w1_free + G (S0 + S1_free) / 2
//! ```
//!
//! a system of two equations. (G^-1 times) the matrix is symmetric and positive, since A <= 2 sum b_n beta_n < 2 K.
//! Both means are linear in the hammer's force, so that it remains one scalar unknown.

use std::f64::consts::PI;

use super::rows::{Block, Row, WIDE, added, transition};
use crate::instrument::BridgeMode;

/// A number in each direction of a string's motion: that of the blow, and across it.
pub(super) type Pair = [f64; 2];

/// The product of two pairs.
#[inline(always)]
pub(super) fn dot(a: Pair, b: Pair) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// A matrix times a pair.
#[inline(always)]
fn times(matrix: [Pair; 2], x: Pair) -> Pair {
    [dot(matrix[0], x), dot(matrix[1], x)]
}

/// The solution of two equations, by elimination.
#[inline(always)]
fn solved([first, second]: [Pair; 2], right: Pair) -> Pair {
    let factor = second[0] / first[0];
    let y = (right[1] - factor * right[0]) / (second[1] - factor * first[1]);
    [(right[0] - first[1] * y) / first[0], y]
}

/// The modes of the bridge, and what couples the strings to them.
#[derive(Debug, Clone, Default)]
pub(super) struct Bridge {
    /// Its modes. `shape` and `bridge` are their displacements of the bridge per metre, vertical and horizontal; `fq`
    /// and `fv` what a newton on the mode does to it in a step.
    blocks: Vec<Block>,
    own: Vec<Own>,
    /// The effect of w on the strings' modes in each direction: the rows' "shape" is b_n.
    pub rows: [Row; 2],
    /// K, N/m.
    stiffness_n_per_m: Pair,
    /// Of all its modes: sum d d^T / k, m/N.
    static_m_per_n: [Pair; 2],
    /// G, m/N.
    gives_m_per_n: [Pair; 2],
    /// 2 + G (K - A/2).
    divisor: [Pair; 2],
    /// By how much the mean w of a step rises per newton of S at its end, m/N.
    per_newton: [Pair; 2],
    /// What follows from where its modes are: w, and its sum with w a step later if nothing pushes them, m.
    now_m: Pair,
    both_m: Pair,
}

/// What modes add up to, by lanes: w, and its sum with w a step later, in each direction.
#[derive(Default)]
struct Sums {
    now: [[f64; WIDE]; 2],
    both: [[f64; WIDE]; 2],
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, Block { q, v, qq, qv, shape, bridge, .. }: &Block) {
        for i in 0..WIDE {
            let both = q[i] + (qq[i] * q[i] + qv[i] * v[i]);
            self.now[0][i] += shape[i] * q[i];
            self.now[1][i] += bridge[i] * q[i];
            self.both[0][i] += shape[i] * both;
            self.both[1][i] += bridge[i] * both;
        }
    }

    fn added(self) -> (Pair, Pair) {
        (self.now.map(added), self.both.map(added))
    }
}

#[derive(Debug, Clone, Copy)]
struct Own {
    mass_kg: f64,
    stiffness_n_per_m: f64,
}

impl Bridge {
    /// At rest. `rows`: b_n of the strings' modes; `stiffness_n_per_m`: K; `answers_n_per_m`: A.
    pub(crate) fn new(
        modes: &[BridgeMode],
        rows: [Row; 2],
        stiffness_n_per_m: Pair,
        answers_n_per_m: Pair,
        step_s: f64,
    ) -> Self {
        let mut blocks = vec![Block::default(); modes.len().div_ceil(WIDE)];
        let (mut own, mut static_m_per_n, mut gives_m_per_n) = (Vec::new(), [[0.0; 2]; 2], [[0.0; 2]; 2]);
        for (index, mode) in modes.iter().enumerate() {
            let omega = 2.0 * PI * mode.frequency_hz;
            let [qq, qv, vq, vv] = transition(omega, 0.5 * mode.loss_factor * omega, step_s);
            let stiffness_n_per_m = mode.mass_kg * omega * omega;
            let (block, lane) = (&mut blocks[index / WIDE], index % WIDE);
            (block.qq[lane], block.qv[lane], block.vq[lane], block.vv[lane]) = (qq, qv, vq, vv);
            (block.fq[lane], block.fv[lane]) = ((1.0 - qq) / stiffness_n_per_m, -vq / stiffness_n_per_m);
            let direction = [1.0, mode.horizontal];
            [block.shape[lane], block.bridge[lane]] = direction;
            for (a, of_a) in direction.into_iter().enumerate() {
                for (b, of_b) in direction.into_iter().enumerate() {
                    static_m_per_n[a][b] += of_a * of_b / stiffness_n_per_m;
                    gives_m_per_n[a][b] += of_a * of_b * (1.0 - qq) / stiffness_n_per_m;
                }
            }
            own.push(Own { mass_kg: mode.mass_kg, stiffness_n_per_m });
        }
        let held: Pair = std::array::from_fn(|d| stiffness_n_per_m[d] - 0.5 * answers_n_per_m[d]);
        let divisor = std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b { 2.0 } else { 0.0 } + gives_m_per_n[a][b] * held[b])
        });
        let [first, second] = [0, 1].map(|b| solved(divisor, [0.5 * gives_m_per_n[0][b], 0.5 * gives_m_per_n[1][b]]));
        let across = 0.5 * (first[1] + second[0]);
        let per_newton = [[first[0], across], [across, second[1]]];
        Bridge {
            blocks,
            own,
            rows,
            stiffness_n_per_m,
            static_m_per_n,
            gives_m_per_n,
            divisor,
            per_newton,
            now_m: [0.0; 2],
            both_m: [0.0; 2],
        }
    }

    /// w, m.
    pub(crate) fn displacement_m(&self) -> Pair {
        self.now_m
    }

    /// Finds what follows from where its modes are, after they have been put somewhere.
    pub(crate) fn look(&mut self) {
        let mut sums = Sums::default();
        for block in &self.blocks {
            sums.add(block);
        }
        (self.now_m, self.both_m) = sums.added();
    }

    /// K in the direction of the blow, N/m.
    pub(crate) fn stiffness_n_per_m(&self) -> f64 {
        self.stiffness_n_per_m[0]
    }

    /// The force of strings of a given S on it, N.
    pub(crate) fn force_n(&self, s_n: Pair) -> Pair {
        let w = self.displacement_m();
        std::array::from_fn(|d| s_n[d] - self.stiffness_n_per_m[d] * w[d])
    }

    /// By how much the mean w of a step rises per newton of S at its end, m/N: symmetric.
    pub(crate) fn per_newton(&self) -> [Pair; 2] {
        self.per_newton
    }

    /// The mean w of a step, m, in which S goes from one value to another if w stays zero.
    pub(crate) fn mean_m(&self, s_n: Pair, s_free_n: Pair) -> Pair {
        let pushed = times(self.gives_m_per_n, [0.5 * (s_n[0] + s_free_n[0]), 0.5 * (s_n[1] + s_free_n[1])]);
        solved(self.divisor, [self.both_m[0] + pushed[0], self.both_m[1] + pushed[1]])
    }

    /// Its modes' step under the mean force, N; what this has done to them, J.
    pub(crate) fn advance(&mut self, force_n: Pair) -> f64 {
        let (before_m, mut sums) = (self.now_m, Sums::default());
        for block in &mut self.blocks {
            let Block { q, v, qq, qv, vq, vv, fq, fv, shape, bridge } = block;
            for i in 0..WIDE {
                let own_n = shape[i] * force_n[0] + bridge[i] * force_n[1];
                let after = qq[i] * q[i] + qv[i] * v[i] + fq[i] * own_n;
                v[i] = vq[i] * q[i] + vv[i] * v[i] + fv[i] * own_n;
                q[i] = after;
            }
            sums.add(block);
        }
        (self.now_m, self.both_m) = sums.added();
        dot(force_n, [self.now_m[0] - before_m[0], self.now_m[1] - before_m[1]])
    }

    /// The mean force of a step in which S and w have gone so far, N.
    pub(crate) fn mean_force_n(&self, s_n: [Pair; 2], mean_m: Pair) -> Pair {
        std::array::from_fn(|d| 0.5 * (s_n[0][d] + s_n[1][d]) - self.stiffness_n_per_m[d] * mean_m[d])
    }

    /// Equilibrium position, m, under the strings' force at w = 0 without inertia, N: they hold the bridge like springs
    /// of T/L (`hold_n_per_m`), (1 + C T/L) w = C F with the bridge's compliance C.
    pub(crate) fn stands_m(&self, force_n: Pair, hold_n_per_m: f64) -> Pair {
        let compliance = self.static_m_per_n;
        let matrix = std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 } + compliance[a][b] * hold_n_per_m)
        });
        solved(matrix, times(compliance, force_n))
    }

    /// Its modes: place, displacement of the bridge per metre, and what they are.
    fn each(&self) -> impl Iterator<Item = (usize, usize, Pair, Own)> + '_ {
        self.own.iter().enumerate().map(|(index, own)| {
            let (block, lane) = (&self.blocks[index / WIDE], index % WIDE);
            (index / WIDE, lane, [block.shape[lane], block.bridge[lane]], *own)
        })
    }

    /// Puts it where it stands under a force of the strings that includes what w takes back, N.
    pub(crate) fn stand(&mut self, force_n: Pair) {
        for (index, own) in self.own.iter().enumerate() {
            let (block, lane) = (&mut self.blocks[index / WIDE], index % WIDE);
            let own_n = block.shape[lane] * force_n[0] + block.bridge[lane] * force_n[1];
            (block.q[lane], block.v[lane]) = (own_n / own.stiffness_n_per_m, 0.0);
        }
    }

    /// Energy of its modes, J.
    pub(crate) fn own_energy_j(&self) -> f64 {
        self.trembles_j([0.0; 2])
    }

    /// The same and that of K, without w S, J.
    pub(crate) fn energy_j(&self) -> f64 {
        let w = self.displacement_m();
        let held: f64 = w.iter().zip(&self.stiffness_n_per_m).map(|(w, k)| 0.5 * k * w * w).sum();
        self.own_energy_j() + held
    }

    /// What vibrates about where it stands under a force, J.
    pub(crate) fn trembles_j(&self, force_n: Pair) -> f64 {
        let of = |(block, lane, direction, own): (usize, usize, Pair, Own)| {
            let r = self.blocks[block].q[lane] - dot(direction, force_n) / own.stiffness_n_per_m;
            let v = self.blocks[block].v[lane];
            0.5 * (own.mass_kg * v * v + own.stiffness_n_per_m * r * r)
        };
        self.each().map(of).sum()
    }

    /// Displacement and velocity of one of its modes.
    pub(crate) fn mode_now(&self, index: usize) -> [f64; 2] {
        if index >= self.own.len() {
            return [0.0; 2];
        }
        let block = &self.blocks[index / WIDE];
        [block.q[index % WIDE], block.v[index % WIDE]]
    }

    /// The sum of its modes' velocities, each with its weights: of weights in Pa s/m the pressures, Pa.
    pub(crate) fn weighted(&self, weights: &[Pair]) -> Pair {
        weights.iter().enumerate().fold([0.0; 2], |[left, right], (index, weight)| {
            let v = self.blocks[index / WIDE].v[index % WIDE];
            [left + weight[0] * v, right + weight[1] * v]
        })
    }

    /// Sets one of them.
    pub(crate) fn set_mode(&mut self, index: usize, velocity: bool, number: f64) {
        if index < self.own.len() {
            let block = &mut self.blocks[index / WIDE];
            (if velocity { &mut block.v } else { &mut block.q })[index % WIDE] = number;
        }
    }

    /// Its modes are where those of another are, which has the same.
    pub(crate) fn go_on_from(&mut self, other: &Self) {
        for (block, other) in self.blocks.iter_mut().zip(&other.blocks) {
            (block.q, block.v) = (other.q, other.v);
        }
    }
}
