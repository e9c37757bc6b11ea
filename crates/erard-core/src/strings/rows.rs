//! Modes side by side, and places at which something presses them.

/// Modes that are stepped side by side. The compiler makes vectors of four; the order of sums is fixed, so that the
/// bits are the same on every target.
pub(super) const WIDE: usize = 4;

/// [`WIDE`] modes of one string. Places beyond its last mode are zero.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Block {
    /// Displacement, m, and velocity, m/s.
    pub q: [f64; WIDE],
    pub v: [f64; WIDE],
    /// The exact step of a free mode: (q, v) -> (qq q + qv v, vq q + vv v).
    pub qq: [f64; WIDE],
    pub qv: [f64; WIDE],
    pub vq: [f64; WIDE],
    pub vv: [f64; WIDE],
    /// Change of q, m, and of v, m/s, by a newton on the hammer's felt that lasts for the step.
    pub fq: [f64; WIDE],
    pub fv: [f64; WIDE],
    /// Its part of the felt's displacement per metre, with the string's share of the felt.
    pub shape: [f64; WIDE],
    /// Its part of the bridge force, N/m.
    pub bridge: [f64; WIDE],
}

/// What a force at another place than the hammer's does to some of the blocks, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Row {
    first: usize,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Part {
    /// As in [`Block`], for this place.
    shape: [f64; WIDE],
    fq: [f64; WIDE],
    fv: [f64; WIDE],
}

impl Row {
    /// A row of so many blocks from the first one on.
    pub(crate) fn new(first: usize, blocks: usize) -> Self {
        Row { first, parts: vec![Part::default(); blocks] }
    }

    /// A mode's displacement at the place per metre of its own, and its stiffness, N/m. The mode's step is known
    /// already.
    pub(crate) fn set(&mut self, at: usize, shape: f64, stiffness_n_per_m: f64, blocks: &[Block]) {
        let (block, lane) = (at / WIDE, at % WIDE);
        let part = &mut self.parts[block - self.first];
        let rests = shape / stiffness_n_per_m;
        part.shape[lane] = shape;
        part.fq[lane] = rests * (1.0 - blocks[block].qq[lane]);
        part.fv[lane] = -rests * blocks[block].vq[lane];
    }

    /// A mode's displacement at the place per metre of its own.
    pub(crate) fn shape(&self, at: usize) -> f64 {
        let part = (at / WIDE).checked_sub(self.first).and_then(|part| self.parts.get(part));
        part.map_or(0.0, |part| part.shape[at % WIDE])
    }

    /// What the modes displace the place by now.
    pub(crate) fn now(&self, blocks: &[Block]) -> f64 {
        let mut sum = [0.0; WIDE];
        for (part, block) in self.parts.iter().zip(&blocks[self.first..]) {
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum += part.shape[i] * block.q[i];
            }
        }
        added(sum)
    }

    /// What they displace it by a step later, if nothing presses them.
    pub(crate) fn free(&self, blocks: &[Block]) -> f64 {
        let mut sum = [0.0; WIDE];
        for (part, block) in self.parts.iter().zip(&blocks[self.first..]) {
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum += part.shape[i] * (block.qq[i] * block.q[i] + block.qv[i] * block.v[i]);
            }
        }
        added(sum)
    }

    /// The modes' step under a force of the hammer, N, and one at the place, N.
    pub(crate) fn step(&self, hammer_n: f64, force_n: f64, blocks: &mut [Block]) {
        for (part, block) in self.parts.iter().zip(&mut blocks[self.first..]) {
            let Block { q, v, qq, qv, vq, vv, fq, fv, .. } = block;
            for i in 0..WIDE {
                let after = qq[i] * q[i] + qv[i] * v[i] + (fq[i] * hammer_n + part.fq[i] * force_n);
                v[i] = vq[i] * q[i] + vv[i] * v[i] + (fv[i] * hammer_n + part.fv[i] * force_n);
                q[i] = after;
            }
        }
    }

    /// Adds to modes that have taken a step what a force at the place has done to them meanwhile.
    pub(crate) fn press(&self, force: f64, blocks: &mut [Block]) {
        for (part, block) in self.parts.iter().zip(&mut blocks[self.first..]) {
            for i in 0..WIDE {
                block.q[i] += part.fq[i] * force;
                block.v[i] += part.fv[i] * force;
            }
        }
    }
}

/// The sum of lanes, in an order that is fixed.
#[inline(always)]
pub(super) fn added(x: [f64; WIDE]) -> f64 {
    (x[0] + x[1]) + (x[2] + x[3])
}

/// The exact step of length h of a free mode: (q, v) -> (qq q + qv v, vq q + vv v). An overdamped one, too.
pub(crate) fn transition(omega: f64, sigma: f64, h: f64) -> [f64; 4] {
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
