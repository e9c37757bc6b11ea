//! Switches of friction laws: a slipping contact begins to stick, or reverses.
//!
//! The derivatives of a motion jump there, because its acceleration does. They do not jump where a sticking law begins
//! to slip (its force has just reached its bound), where a felt begins or ceases to push (its force is continuous,
//! too), or where the force of a felt reaches the limit zero.

use crate::dual::Dual;
use crate::model::Model;
use crate::state::State;
use crate::workspace::Workspace;

/// Slower than this, rad/s or m/s, sticks: the solver's tolerance.
const STILL: f64 = 1e-11;

/// A set-valued law that may switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SwitchingLaw {
    /// Dry friction of a pivot.
    Pivot(usize),
    /// Coulomb friction of a zone.
    Zone(usize),
}

impl SwitchingLaw {
    /// Which way it slips after a step: 0 where it sticks.
    pub(crate) fn side<const B: usize, const Z: usize>(
        self,
        model: &Model<f64, B, Z>,
        state: &State<f64, B, Z>,
    ) -> f64 {
        match self {
            SwitchingLaw::Pivot(i) => side(model.tree.relative(&state.velocity)[i]),
            // The remembered side is the force's.
            SwitchingLaw::Zone(z) => -state.side[z],
        }
    }
}

/// What becomes of a law in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// A sliding contact sticks or reverses: derivatives jump.
    Switches(SwitchingLaw),
    /// A sticking contact slips: derivatives do not jump, but a step over that instant has the wrong law for a part of
    /// it.
    LetsGo(SwitchingLaw),
}

impl Change {
    fn of(law: SwitchingLaw, before: f64, after: f64) -> Option<Self> {
        match (before != 0.0, before != after) {
            (_, false) => None,
            (true, true) => Some(Change::Switches(law)),
            (false, true) => Some(Change::LetsGo(law)),
        }
    }

    /// The law that switches, if it does.
    pub(crate) fn switch(self) -> Option<SwitchingLaw> {
        if let Change::Switches(law) = self { Some(law) } else { None }
    }
}

/// Laws that have let go in a step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LetGo(u128);

impl LetGo {
    fn bit(law: SwitchingLaw) -> u128 {
        let (SwitchingLaw::Pivot(i) | SwitchingLaw::Zone(i)) = law;
        let place = if matches!(law, SwitchingLaw::Pivot(_)) { i } else { 64 + i };
        1_u128.checked_shl(place as u32).unwrap_or(0)
    }

    pub(crate) fn add(&mut self, law: SwitchingLaw) {
        self.0 |= LetGo::bit(law);
    }

    /// Whether a change is news.
    pub(crate) fn is_new(&self, change: Change) -> bool {
        if let Change::LetsGo(law) = change { self.0 & LetGo::bit(law) == 0 } else { true }
    }
}

fn side(u: f64) -> f64 {
    if u.abs() <= STILL { 0.0 } else { u.signum() }
}

/// Which way the laws slip before a step, as far as that is known without it: 0 where they stick.
pub(super) struct Before<const B: usize, const Z: usize> {
    w: [f64; B],
    /// Of zones that were pressed.
    zone: [Option<f64>; Z],
}

impl<const B: usize, const Z: usize> Before<B, Z> {
    pub(crate) fn of(model: &Model<f64, B, Z>, state: &State<f64, B, Z>) -> Self {
        let zone = core::array::from_fn(|z| {
            let pressed = state.side[z] != 0.0 || state.tangential[z] != 0.0;
            // The remembered side is the force's.
            pressed.then_some(-state.side[z])
        });
        Before { w: model.tree.relative(&state.velocity), zone }
    }

    /// The laws that slip before a step and stick or slip the other way after it, and those that stick before it and
    /// slip after it: [`Change`].
    pub(crate) fn changes<'a, const N: usize>(
        &'a self,
        model: &'a Model<f64, B, Z>,
        step: &'a Workspace<f64, B, Z, N>,
        after: &'a State<f64, B, Z>,
    ) -> impl Iterator<Item = Change> + 'a {
        let w1 = model.tree.relative(&after.velocity);
        let pivots = (0..B).filter(|&i| model.dry[i] > 0.0);
        let pivots = pivots.filter_map(move |i| Change::of(SwitchingLaw::Pivot(i), side(self.w[i]), side(w1[i])));
        let sliding = model.sliding_zones[..model.sliding_count].iter().copied();
        let zones = sliding.filter_map(move |z| {
            let pressed = step.touched_in(z) && step.contacts.states[z].force > 0.0;
            if !pressed {
                return None;
            }
            // A force may be at its bound although nothing slips: what is stuck in several places at once shares its
            // load as the solver happens to find it. That is no switch.
            let slips = |w: &[f64; B]| side(model.supports[z].product(&step.contacts.slip_row[z], w));
            let remembered = |remembered: f64, w: &[f64; B]| if slips(w) == 0.0 { 0.0 } else { remembered };
            let before = self.zone[z].map_or_else(|| slips(&self.w), |side| remembered(side, &self.w));
            Change::of(SwitchingLaw::Zone(z), before, remembered(-after.side[z], &w1))
        });
        pivots.chain(zones)
    }
}

/// How fast the laws slip at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slips<const B: usize, const Z: usize, const D: usize> {
    pivot: [Dual<D>; B],
    zone: [Dual<D>; Z],
}

impl<const B: usize, const Z: usize, const D: usize> Slips<B, Z, D> {
    pub(crate) const fn none() -> Self {
        Slips { pivot: [Dual::constant(0.0); B], zone: [Dual::constant(0.0); Z] }
    }

    /// From the relative velocities at the end of the step, and what acted in it.
    pub(crate) fn of<const N: usize>(
        model: &Model<Dual<D>, B, Z>,
        step: &Workspace<Dual<D>, B, Z, N>,
        w: &[Dual<D>; B],
    ) -> Self {
        let mut slips = Slips { pivot: *w, ..Slips::none() };
        for &z in &model.sliding_zones[..model.sliding_count] {
            if step.touched_in(z) {
                slips.zone[z] = model.supports[z].product(&step.contacts.slip_row[z], w);
            }
        }
        slips
    }

    pub(crate) fn slip(&self, law: SwitchingLaw) -> Dual<D> {
        match law {
            SwitchingLaw::Pivot(i) => self.pivot[i],
            SwitchingLaw::Zone(z) => self.zone[z],
        }
    }
}
