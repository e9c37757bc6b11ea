//! Pieces of work on a key, and their steps.

use crate::balance::{Lead, LeadWork, add_mass};
use crate::measure::MeasureError;
use crate::regulate::{Handwork, known_screw, way};
use crate::weighing::Scale;
use erard::Progress;
use erard::grand::{Anatomy, Parts, strike_weight_g};
use erard::instrument::{Instrument, InvalidInstrument};

/// Smallest changes and steps of lines, g and mm: friction, weighed as D and U in steps of 2 g; hammers and front
/// weights, on the scale; the capstan line; paper under the key; the back check's wire (1 mm of checking distance is a
/// tenth of it).
const FRICTION_G: f64 = 2.0;
const HAMMER_G: f64 = 0.1;
pub(super) const FRONT_G: f64 = 0.5;
const CAPSTAN_MM: f64 = 0.5;
const PAPER_M: f64 = 1e-4;
const CHECK_WIRE_M: f64 = 1e-4;
/// Step of a screw, turns.
const TURN: f64 = 0.125;
/// Steps of bending a spring, N m, and a check's wire, rad.
const SPRING_N_M: f64 = 5e-4;
const CHECK_ANGLE_RAD: f64 = 0.017_453_292_519_943_295;
/// Place of front weight put or taken if no leads are named, as a share of the key's front arm.
const LEADS_AT: f64 = 0.6;
/// Bushings and pins are not eased below this share of their friction.
const LEAST_FRICTION: f64 = 0.1;
/// Tolerance of a friction weight, g, and most weighings to reach it.
pub(super) const FRICTION_FOUND_G: f64 = 0.05;
const WEIGHINGS: u32 = 8;

/// Piece of work on a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Work {
    /// Bushings, pins and knuckle eased (negative) or tightened, g of friction weight.
    Friction {
        /// g.
        by_g: f64,
    },
    /// The capstan toward the player, mm.
    Capstan {
        /// mm.
        by_mm: f64,
    },
    /// Weight added to the hammer head, g of strike weight; negative if removed.
    Hammer {
        /// g.
        by_g: f64,
    },
    /// A screw turned, a punching laid, a wire bent: the setting's change in SI units.
    Screw {
        /// The screw's name in instrument files.
        name: &'static str,
        /// m, rad, or N m.
        by: f64,
    },
    /// Known leads moved, taken out, or added.
    Leads(LeadWork),
    /// Front weight changed without known leads, g.
    FrontWeight {
        /// g.
        by_g: f64,
    },
}

impl Work {
    /// Returns the step of the hand, in the work's unit (g, mm, m, rad, N m).
    #[must_use]
    pub fn step(&self) -> f64 {
        match self {
            Work::Friction { .. } => FRICTION_G,
            Work::Capstan { .. } => CAPSTAN_MM,
            Work::Hammer { .. } => HAMMER_G,
            Work::Leads(_) | Work::FrontWeight { .. } => FRONT_G,
            Work::Screw { name, .. } => screw_step(name),
        }
    }

    /// Returns the amount of work, in the same unit.
    #[must_use]
    pub fn amount(&self) -> f64 {
        match self {
            Work::Friction { by_g } | Work::Hammer { by_g } | Work::FrontWeight { by_g } => *by_g,
            Work::Capstan { by_mm } => *by_mm,
            Work::Screw { by, .. } => *by,
            Work::Leads(leads) => leads.front_weight_g,
        }
    }

    /// Returns this work with another amount. For leads, the last one put in, or else the last one taken out, stands a
    /// little further out or in.
    #[must_use]
    pub fn with_amount(&self, amount: f64, key_front_mm: f64) -> Work {
        match self {
            Work::Friction { .. } => Work::Friction { by_g: amount },
            Work::Capstan { .. } => Work::Capstan { by_mm: amount },
            Work::Hammer { .. } => Work::Hammer { by_g: amount },
            Work::FrontWeight { .. } => Work::FrontWeight { by_g: amount },
            Work::Screw { name, .. } => Work::Screw { name, by: amount },
            Work::Leads(leads) => {
                let mut leads = leads.clone();
                let by_g = amount - leads.front_weight_g;
                let shifted = |lead: &mut Lead, sign: f64| lead.at_mm += sign * by_g * key_front_mm / lead.mass_g;
                match (leads.put.last_mut(), leads.out.last_mut()) {
                    (Some(put), _) => shifted(put, 1.0),
                    (None, Some(out)) => shifted(out, -1.0),
                    (None, None) => {}
                }
                leads.front_weight_g = amount;
                Work::Leads(leads)
            }
        }
    }

    /// Returns the work in whole steps; `None` if it is less than half a step.
    #[must_use]
    pub(super) fn in_steps(&self) -> Option<Work> {
        let steps = (self.amount() / self.step()).round();
        (steps != 0.0).then(|| match self {
            // Leads stand at whole millimetres. Friction is eased with weights on the key, to what they read.
            Work::Leads(_) | Work::Friction { .. } => self.clone(),
            _ => self.with_amount(steps * self.step(), 0.0),
        })
    }

    /// Direction, in a word or two, for a screw: `up`, `to the back`, `tighter`.
    #[must_use]
    pub fn way(&self, instrument: &Instrument) -> &'static str {
        match self {
            Work::Screw { name, by } => {
                instrument.screw(name).map_or("", |screw| way(&instrument.screws[screw].action, *by))
            }
            Work::Capstan { by_mm } if *by_mm < 0.0 => "to the back",
            Work::Capstan { .. } => "to the player",
            _ => "",
        }
    }

    /// Carries out the work on an instrument.
    ///
    /// # Errors
    /// Errors of weighing, because friction is eased with a weight on the key.
    pub fn carry_out(&self, instrument: &mut Instrument, progress: &mut Progress<'_>) -> Result<(), MeasureError> {
        self.carry_out_on(&mut Scale::default(), instrument, progress)
    }

    /// The same with a scale that may know the action.
    ///
    /// # Errors
    /// See [`MeasureError`].
    pub(super) fn carry_out_on(
        &self,
        scale: &mut Scale,
        instrument: &mut Instrument,
        progress: &mut Progress<'_>,
    ) -> Result<(), MeasureError> {
        match self {
            Work::Friction { by_g } => return ease(instrument, Rubs::Everywhere, *by_g, scale, progress),
            Work::Capstan { by_mm } => {
                if let Some(zone) = capstan(instrument)? {
                    instrument.edit(|fields| fields.zones[zone].disc_center_m[0] -= 1e-3 * by_mm)?;
                }
            }
            Work::Hammer { by_g } => hammer(instrument, *by_g)?,
            Work::Screw { name, by } => {
                if let Some(screw) = instrument.screw(name) {
                    let setting = instrument.screws[screw].setting + by;
                    let _ = instrument.turn(screw, setting);
                }
            }
            Work::Leads(leads) => {
                let leads = leads.put.iter().map(|lead| (*lead, 1.0)).chain(leads.out.iter().map(|lead| (*lead, -1.0)));
                for (lead, sign) in leads {
                    front(instrument, sign * lead.mass_g, lead.at_mm)?;
                }
            }
            Work::FrontWeight { by_g } => {
                let front_mm = 1e3 * instrument.roles.key_front_m[0].abs();
                front(instrument, by_g / LEADS_AT, LEADS_AT * front_mm)?;
            }
        }
        Ok(())
    }
}

/// Step of a screw, SI units.
pub(super) fn screw_step(name: &str) -> f64 {
    match known_screw(name).map(|known| known.work) {
        Some(Handwork::Thread(pitch_m)) => TURN * pitch_m,
        Some(Handwork::Bent) if name == "repetition_spring" => SPRING_N_M,
        Some(Handwork::Bent) if name == "back_check_angle" => CHECK_ANGLE_RAD,
        Some(Handwork::Bent) => CHECK_WIRE_M,
        Some(Handwork::Layers | Handwork::Stack) | None => PAPER_M,
    }
}

/// Zone of capstan and heel.
fn capstan(instrument: &Instrument) -> Result<Option<usize>, MeasureError> {
    let parts = Parts::of(instrument)?;
    let key = instrument.first_piece(parts.key)?;
    let is_of = |body: Option<usize>, part: usize| {
        body.and_then(|body| instrument.first_piece(body).ok()).is_some_and(|piece| piece == part)
    };
    let is_capstan =
        |zone: &erard::instrument::Zone| is_of(zone.disc_body, key) && is_of(zone.curve_body, parts.whippen);
    Ok(instrument.zones.iter().position(is_capstan))
}

/// Adds a mass to the key, at this distance in front of its pin.
fn front(instrument: &mut Instrument, mass_g: f64, at_mm: f64) -> Result<(), MeasureError> {
    let parts = Parts::of(instrument)?;
    // The piece behind the pin rests on it.
    let body = if at_mm > 0.0 { parts.key } else { instrument.first_piece(parts.key)? };
    let height_m = instrument.bodies[body].center_of_mass_m[1];
    Ok(add_mass(instrument, body, 1e-3 * mass_g, [-1e-3 * at_mm, height_m])?)
}

/// Adds strike weight to the hammer's head, at the strike point's place along the shank.
fn hammer(instrument: &mut Instrument, by_g: f64) -> Result<(), MeasureError> {
    let parts = Parts::of(instrument)?;
    let weighed = |instrument: &Instrument| -> Result<f64, MeasureError> {
        let rigid = instrument.locked();
        Ok(strike_weight_g(&rigid, &Parts::of(&rigid)?)?)
    };
    let before = weighed(instrument)?;
    let height_m = instrument.bodies[parts.hammer].center_of_mass_m[1];
    add_mass(instrument, parts.hammer, 1e-3 * by_g, [instrument.roles.hammer_strike_point_m[0], height_m])?;
    debug_assert!((weighed(instrument)? - before - by_g).abs() < 1e-6);
    Ok(())
}

/// Place where friction changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rubs {
    /// All pins between finger and string: a weight does not show where it rubs.
    Everywhere,
    /// At the key's pins.
    Key,
}

/// Eases pins and bushings by one factor until the friction weight has changed by `by_g`.
pub(super) fn ease(
    instrument: &mut Instrument,
    rubs: Rubs,
    by_g: f64,
    scale: &mut Scale,
    progress: &mut Progress<'_>,
) -> Result<(), MeasureError> {
    let anatomy = Anatomy::find(instrument)?;
    let [key, whippen, hammer] =
        [anatomy.key, anatomy.whippen, anatomy.hammer].map(|body| instrument.first_piece(body));
    let all = [key?, whippen?, hammer?];
    let pins = if rubs == Rubs::Key { &all[..1] } else { &all[..] };
    let eased = |instrument: &Instrument, factor: f64| -> Result<Instrument, InvalidInstrument> {
        let mut eased = instrument.clone();
        eased.edit(|fields| pins.iter().for_each(|pin| fields.bodies[*pin].friction_torque_n_m *= factor))?;
        Ok(eased)
    };
    let Some(before_g) = scale.touch(instrument, progress)?.friction_weight_g() else { return Ok(()) };
    let wanted_g = before_g + by_g;
    // These pins make up three quarters of the friction weight.
    let mut factor = (1.0 + by_g / (0.75 * before_g)).max(LEAST_FRICTION);
    let (mut last, mut slope) = ((1.0, before_g), 0.75 * before_g);
    for _ in 0..WEIGHINGS {
        let Some(found_g) = scale.touch(&eased(instrument, factor)?, progress)?.friction_weight_g() else { break };
        if (found_g - wanted_g).abs() < FRICTION_FOUND_G {
            break;
        }
        let found = (found_g - last.1) / (factor - last.0);
        if found.is_finite() && found > 0.2 * slope {
            slope = found;
        }
        last = (factor, found_g);
        let next = (factor + (wanted_g - found_g) / slope).max(LEAST_FRICTION);
        if next == factor {
            break;
        }
        factor = next;
    }
    *instrument = eased(instrument, factor)?;
    Ok(())
}
