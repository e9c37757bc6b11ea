//! Into how many parts a step is taken, and the change between their lengths.
//!
//! **Which modes exist** does not depend on a step's length: all up to 20 kHz, each moving exactly at any. A step
//! cannot follow changes of the felt's force, which it holds constant. So steps are short while the hammer is near the
//! strings, and long while nothing but dampers touches them.
//!
//! **How short.** The sound depends on the shape of the force: partials that are 40 dB weaker than the strongest lie
//! between lobes of its spectrum, where a thousandth of a change of the pulse is a tenth of a decibel. The scale of a
//! pulse is the time for which the hammer would touch a wall; steps of a 160th of that are enough for every key of the
//! concert grand, while peak, contact and return need a tenth as many.
//!
//! **A change** copies displacements and velocities, so that not a bit of energy is lost by it: all that stores any
//! (modes, static compliances, the bridge) is the same in both lengths.

use std::f64::consts::PI;

use moreau_kernels::Parts;

use super::{Bridge, Prepared, Strings};
use crate::instrument::Instrument;

/// Steps in which nothing but dampers touches the strings are not longer, s.
const MAX_STEP_S: f64 = 50e-6;
/// Likewise where a bridge moves, s: strings and bridge exchange means over a step. In steps of 50 us the energy of a
/// note is a twentieth too low after half a second, in steps of 25 us an eightieth (`tests/it/dampers.rs`), and in the
/// usual ones, which this allows, a thirtieth: 0.15 dB. Sound is written in shorter steps.
const MAX_STEP_ON_A_BRIDGE_S: f64 = 1.0 / 24e3;
/// Hammers are not faster, m/s, nor does anything else come nearer to a string faster.
const FASTEST_M_PER_S: f64 = 20.0;
/// A fortissimo, m/s.
const FORTISSIMO_M_PER_S: f64 = 5.0;
/// Steps for which a hammer would touch a wall then, at least: with so many, partials within 40 dB of the strongest are
/// right to 0.1 dB at a fortissimo on every key of the concert grand, and all else to a hundredth
/// (`tests/it/halving.rs`). The hardest are partials of the sixth octave that the strike point leaves weak.
const STEPS_OF_A_BLOW: f64 = 160.0;
/// Where no hammer is known, s.
const UNKNOWN_S: f64 = 1.0 / 96e3;
/// Rounding that a step may be longer by and still count as no longer.
const NEARLY: f64 = 1.0 + 1e-9;
/// Steps are not halved more often.
const MAX_HALVINGS: u32 = 10;

/// The longest step, s, that the strings of an instrument may be struck in: a part of the time for which their hammer
/// would touch a wall in a fortissimo.
pub(super) fn impact_step_s(instrument: &Instrument) -> f64 {
    wall_contact_s(instrument).map_or(UNKNOWN_S, |time_s| time_s / STEPS_OF_A_BLOW)
}

/// For how long the hammer would touch a wall with which it collides at 5 m/s: with its mass m at the strike point and
/// a felt of F = K d^p that loses nothing,
///
/// ```text
/// m v^2 / 2 = K d^(p+1) / (p+1),   t = 2 d/v sqrt(pi) Gamma(1 + 1/(p+1)) / Gamma(1/2 + 1/(p+1))
/// ```
fn wall_contact_s(instrument: &Instrument) -> Option<f64> {
    let (hammer, zone) = (instrument.roles.hammer?, instrument.roles.string?);
    let [x, y] = instrument.roles.hammer_strike_point_m;
    let (felt, mass_kg) = (&instrument.zones[zone].felt, instrument.bodies[hammer].inertia_kg_m2 / (x * x + y * y));
    let n = felt.exponent + 1.0;
    let deep_m = libm::pow(0.5 * n * mass_kg * FORTISSIMO_M_PER_S * FORTISSIMO_M_PER_S / felt.stiffness, 1.0 / n);
    let flight = PI.sqrt() * libm::tgamma(1.0 + 1.0 / n) / libm::tgamma(0.5 + 1.0 / n);
    let time_s = 2.0 * deep_m / FORTISSIMO_M_PER_S * flight;
    (time_s.is_finite() && time_s > 0.0).then_some(time_s)
}

impl Strings {
    /// For steps of a length, s.
    pub(super) fn parts_of(&self, step_s: f64) -> Parts {
        let halvings = |longest_s: f64| {
            (0..MAX_HALVINGS).find(|n| step_s <= longest_s * NEARLY * f64::from(1 << n)).unwrap_or(MAX_HALVINGS)
        };
        let apart = halvings(if self.bridge_modes.is_empty() { MAX_STEP_S } else { MAX_STEP_ON_A_BRIDGE_S });
        let near = halvings(self.impact_step_s).max(apart);
        Parts { apart: 1 << apart, near: 1 << near, reach_m: FASTEST_M_PER_S * step_s }
    }

    /// For steps of a length, s, and their parts. What vibrates goes on.
    pub(super) fn prepare(&mut self, step_s: f64, parts: &Parts) {
        let (before, bridge_before) = (std::mem::take(&mut self.blocks), self.bridge.take());
        let [apart_s, near_s] = [parts.apart, parts.near].map(|parts| step_s / f64::from(parts));
        self.other = (near_s != apart_s).then(|| {
            self.make_modes(near_s);
            Box::new(Prepared {
                step_s: near_s,
                blocks: self.blocks.clone(),
                felts: self.felts.clone(),
                bridge: self.bridge.take(),
                compliance_m_per_n: self.compliance_m_per_n,
                sounds: self.sounds,
                rocked_m_per_n: self.rocked_m_per_n,
            })
        });
        self.make_modes(apart_s);
        (self.prepared_for, self.near) = ((step_s, *parts), false);
        self.go_on_from(&before, bridge_before.as_ref());
    }

    /// From one length to the other. Does not allocate.
    pub(super) fn change_parts(&mut self) {
        self.near = !self.near;
        let Some(mut other) = self.other.take() else { return };
        std::mem::swap(&mut self.step_s, &mut other.step_s);
        std::mem::swap(&mut self.blocks, &mut other.blocks);
        std::mem::swap(&mut self.felts, &mut other.felts);
        std::mem::swap(&mut self.bridge, &mut other.bridge);
        std::mem::swap(&mut self.compliance_m_per_n, &mut other.compliance_m_per_n);
        std::mem::swap(&mut self.sounds, &mut other.sounds);
        std::mem::swap(&mut self.rocked_m_per_n, &mut other.rocked_m_per_n);
        self.go_on_from(&other.blocks, other.bridge.as_ref());
        self.other = Some(other);
    }

    /// Where everything was in steps of another length.
    fn go_on_from(&mut self, before: &[super::Block], bridge: Option<&Bridge>) {
        for (new, old) in self.blocks.iter_mut().zip(before) {
            (new.q, new.v) = (old.q, old.v);
        }
        if let (Some(new), Some(old)) = (&mut self.bridge, bridge) {
            new.go_on_from(old);
        }
        if self.still {
            self.stand();
        } else {
            self.update_surfaces();
        }
    }
}
