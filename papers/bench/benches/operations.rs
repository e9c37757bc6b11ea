//! Floating-point operations per step of the played note that `press` times, by kind: the floor under any number of
//! instructions.
//!
//! `cargo bench -p erard-bench --bench operations`. The engine's own step is run on a number that counts what is done
//! with it, so that the counts are the kernel's and repeat to the digit. Steps at rest and steps in motion are
//! distinguished.

use std::cell::Cell;
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use erard::assembly;
use erard_bench::{STEP_S, STEPS, grand, instrument, note};
use moreau::{Model, Real, Scalar, Settings, SiteInput, State, Workspace, step};

/// The kinds that are counted.
const KINDS: [&str; 7] =
    ["additions", "multiplications", "divisions", "square roots", "comparisons", "choices", "signs and absolutes"];

thread_local! {
    static COUNTS: Cell<[u64; KINDS.len()]> = const { Cell::new([0; KINDS.len()]) };
}

fn count(kind: usize) {
    COUNTS.with(|counts| {
        let mut now = counts.get();
        now[kind] += 1;
        counts.set(now);
    });
}

/// A double that counts.
#[derive(Debug, Clone, Copy)]
struct Counted(f64);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt, $kind:literal) => {
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count($kind);
                Counted(self.0 $op other.0)
            }
        }
    };
}

operator!(Add, add, +, 0);
operator!(Sub, sub, -, 0);
operator!(Mul, mul, *, 1);
operator!(Div, div, /, 2);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        count(6);
        Counted(-self.0)
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl PartialEq for Counted {
    fn eq(&self, other: &Self) -> bool {
        count(4);
        self.0 == other.0
    }
}

impl PartialOrd for Counted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        count(4);
        self.0.partial_cmp(&other.0)
    }
}

const fn counted([a, b, c, d, e, f]: [f64; 6]) -> [Counted; 6] {
    [Counted(a), Counted(b), Counted(c), Counted(d), Counted(e), Counted(f)]
}

impl Real for Counted {
    type Mask = bool;
    type Lane = Counted;
    const LANES: usize = 1;
    const FIRST_APART: bool = true;
    const ZERO: Self = Counted(0.0);
    const ONE: Self = Counted(1.0);
    const EPSILON: Self = Counted(f64::EPSILON);
    const SINE: &'static [Self; 6] = &counted(moreau::SINE);
    const COSINE: &'static [Self; 6] = &counted(moreau::COSINE);
    fn from_f64(x: f64) -> Self {
        Counted(x)
    }
    fn join(x: impl Fn(usize) -> Self) -> Self {
        x(0)
    }
    fn lane(self, _: usize) -> Self {
        self
    }
    fn with_lane(self, _: usize, x: Self) -> Self {
        x
    }
    fn sqrt(self) -> Self {
        count(3);
        Counted(self.0.sqrt())
    }
    fn abs(self) -> Self {
        count(6);
        Counted(self.0.abs())
    }
    fn max(self, other: Self) -> Self {
        count(5);
        Counted(Real::max(self.0, other.0))
    }
    fn min(self, other: Self) -> Self {
        count(5);
        Counted(Real::min(self.0, other.0))
    }
    fn lt(self, other: Self) -> bool {
        count(4);
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        count(4);
        self.0 <= other.0
    }
    fn finite(self) -> bool {
        count(4);
        self.0.is_finite()
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        count(5);
        if mask { yes } else { no }
    }
    fn powf(self, exponent: Self) -> Self {
        Counted(Real::powf(self.0, exponent.0))
    }
    fn tanh(self) -> Self {
        Counted(Real::tanh(self.0))
    }
    fn sin_cos_any(self) -> (Self, Self) {
        let (s, c) = self.0.sin_cos_any();
        (Counted(s), Counted(c))
    }
}

impl Scalar for Counted {
    fn to_f64(self) -> f64 {
        self.0
    }
}

fn main() {
    let model: Model<Counted, 6, 14> = assembly::assemble(&instrument()).expect("fits");
    let mut state = State::<Counted, 6, 14>::at_rest(grand().1.angle.map(Counted));
    let mut workspace = Workspace::<Counted, 6, 14, 10>::new();
    let settings = Settings::in_lanes(&Settings::new(STEP_S));
    // At rest, in motion: steps and counts.
    let mut found = [(0_u64, [0_u64; KINDS.len()]); 2];
    for n in 0..STEPS {
        let SiteInput::Force(force) = note(n) else { unreachable!("the note is a force") };
        COUNTS.with(|counts| counts.set([0; KINDS.len()]));
        step(&model, &settings, &SiteInput::Force(Counted(force)), &mut state, &mut workspace);
        let counts = COUNTS.with(Cell::get);
        let moves = state.velocity.iter().any(|v| v.0 != 0.0);
        let (steps, sums) = &mut found[usize::from(moves)];
        *steps += 1;
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += count;
        }
    }
    let per_step = |k: usize, kind: usize| found[k].1[kind] as f64 / found[k].0.max(1) as f64;
    println!("{:<22}{:>10}{:>12}", "operations a step", "at rest", "in motion");
    for (kind, name) in KINDS.iter().enumerate() {
        println!("{name:<22}{:>10.0}{:>12.0}", per_step(0, kind), per_step(1, kind));
    }
    let all = |k: usize| (0..KINDS.len()).map(|kind| per_step(k, kind)).sum::<f64>();
    println!("{:<22}{:>10.0}{:>12.0}", "all", all(0), all(1));
    println!("{:<22}{:>10}{:>12}", "steps", found[0].0, found[1].0);
}
