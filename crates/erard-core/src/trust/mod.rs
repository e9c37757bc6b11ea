//! Whether a run can be trusted: its results are compared with stated bounds, and every bound that it exceeds is a
//! warning.
//!
//! A simulation always gives numbers. The following signs show that they do not describe the instrument: energy that
//! the energy balance does not explain, steps that did not converge, a felt compressed beyond its thickness, a body
//! turned beyond its stops or to the wrong side of its rest, a hammer faster than any real one or than its energy
//! allows, a point off its body, strings struck in too few or too long steps, no rest to start from. A run without a
//! warning has shown none of these signs; that does not prove it right.
//!
//! ```
//! use erard_core::{Input, Instrument, Setup, press};
//!
//! let grand = Instrument::builtin("concert-grand")?;
//! let run = press(&grand, &|_| Input::Force(5.0), &Setup::new(0.1))?;
//! assert!(run.is_trusted());
//! // Ten thousand newtons crush whatever stands in their way.
//! let crushed = press(&grand, &|_| Input::Force(10_000.0), &Setup::new(0.01))?;
//! assert!(crushed.warnings.iter().any(|w| w.kind == erard_core::trust::WarningKind::FeltBeyondThickness));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod extremes;
mod shapes;
mod strings;

pub use extremes::{Blow, Extremes, Furthest};
pub use strings::Struck;

use std::collections::BTreeMap;

use moreau::Ledger;
use serde::Serialize;

use crate::events::Events;
use crate::instrument::{Instrument, PianoString, REACH_HZ, STEEL_DENSITY_KG_M3};
use crate::player::Work;

/// Largest energy that the energy balance may leave unexplained, over the energy turned over ([`energy_residual`]).
pub const ENERGY_RESIDUAL: f64 = 0.01;
/// Steps that may end without convergence: none.
pub(crate) const UNCONVERGED_STEPS: u64 = 0;
/// Fastest hammer, m/s: four times the fastest measured on a piano, and the speed up to which the engine finds contacts
/// within a step.
pub(crate) const HAMMER_SPEED_M_PER_S: f64 = 20.0;
/// Smallest number of steps with a force in the loudest impact on modal strings: with this many, its contact, its
/// largest force and the hammer's return are right to a hundredth.
pub(crate) const CONTACT_STEPS: u32 = 60;
/// Tensile strength of steel wire, Pa: the thinnest music wire breaks at 3.0e9 (ASTM A228: 2.9e9 to 3.2e9 at 0.3 mm),
/// that of treble strings at 2.5e9.
pub(crate) const STEEL_STRENGTH_PA: f64 = 3.2e9;
/// Highest that a key's front may rise above its rest, m. The back-rail cloth, some 5 mm thick, would be pressed by 2.5
/// mm, with 200 N; a key that comes back from fortissimo presses it by a fifth of that.
pub(crate) const KEY_ABOVE_REST_M: f64 = 3e-3;
/// Deepest that the strike point may fall below its rest, m. The rest cushion lies 6 mm below, as seen from there, so
/// that 3 mm of it would be pressed.
pub(crate) const HAMMER_BELOW_REST_M: f64 = 1e-2;
/// Largest angle of a body at rest from its drawn position, rad. Actions are drawn at rest; regulation turns no part by
/// half of it.
pub(crate) const REST_RAD: f64 = 10.0 * core::f64::consts::PI / 180.0;
/// Turnover below which the residual is measured against this, J: a thousandth of the softest note's.
pub const LEAST_TURNOVER_J: f64 = 1e-6;

/// Kind of doubt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WarningKind {
    /// The energy balance does not close.
    EnergyResidual,
    /// Steps reached an iteration limit.
    UnconvergedSteps,
    /// A felt was compressed beyond its thickness.
    FeltBeyondThickness,
    /// A body turned beyond its stops.
    TurnBeyondStops,
    /// A pivot moved further along its pin than the model holds for.
    LiftBeyondPin,
    /// The hammer met the string faster than any real hammer.
    HammerSpeed,
    /// The hammer met the string faster than all energy that was given could have made it.
    SpeedBeyondEnergy,
    /// The key's front rose above its rest, or the hammer fell below its own.
    BeyondRest,
    /// A contact, hinge or role lies off its body.
    PointOffBody,
    /// The hammer's contact with modal strings took too few steps.
    ContactSteps,
    /// The steps of an impact are too long for some partials of the strings.
    PartialsBeyondStep,
    /// The tension of a string exceeds the strength of steel.
    StringTension,
    /// The rest lies far from how the action is drawn.
    RestFarFromDrawing,
    /// No rest was found to start from, and nothing was played.
    NoRest,
    /// A number became infinite, and the run ended there.
    NonFinite,
}

impl WarningKind {
    /// Its name, as in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            WarningKind::EnergyResidual => "energy_residual",
            WarningKind::UnconvergedSteps => "unconverged_steps",
            WarningKind::FeltBeyondThickness => "felt_beyond_thickness",
            WarningKind::TurnBeyondStops => "turn_beyond_stops",
            WarningKind::LiftBeyondPin => "lift_beyond_pin",
            WarningKind::HammerSpeed => "hammer_speed",
            WarningKind::SpeedBeyondEnergy => "speed_beyond_energy",
            WarningKind::BeyondRest => "beyond_rest",
            WarningKind::PointOffBody => "point_off_body",
            WarningKind::ContactSteps => "contact_steps",
            WarningKind::PartialsBeyondStep => "partials_beyond_step",
            WarningKind::StringTension => "string_tension",
            WarningKind::RestFarFromDrawing => "rest_far_from_drawing",
            WarningKind::NoRest => "no_rest",
            WarningKind::NonFinite => "non_finite",
        }
    }
}

/// A bound that a run has exceeded.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Warning {
    /// Kind of doubt.
    pub kind: WarningKind,
    /// The doubt as a sentence, without a full stop.
    pub what: String,
    /// The zone or body concerned; `None` for the whole run.
    pub part: Option<String>,
    /// Value found, in `unit`.
    pub value: f64,
    /// Largest allowed value, in `unit` (smallest, for a negative turn and for the steps of a contact).
    pub bound: f64,
    /// Unit of value and bound: `m`, `rad`, `N`, `steps`, `partials`, `m/s`, `rad/s`, or empty for a share.
    pub unit: &'static str,
    /// Instant of the worst value on the stroke's clock, s; `None` for the whole run.
    pub time_s: Option<f64>,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.what)
    }
}

/// The residual of the energy balance, relative to the turnover: the largest of the drive's work, all losses, and
/// [`LEAST_TURNOVER_J`].
#[must_use]
pub fn energy_residual(ledger: &Ledger) -> f64 {
    ledger.residual().abs() / ledger.drive_work_in.max(ledger.dissipated()).max(LEAST_TURNOVER_J)
}

/// All bounds that a run has exceeded. `ledger`: the energy balance, if it was kept; without it the energy is not
/// judged.
#[must_use]
pub(crate) fn assess(
    instrument: &Instrument,
    extremes: &Extremes,
    struck: &Struck,
    events: &Events,
    ledger: Option<&Ledger>,
    work: &Work,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    warnings.extend(ledger.map(energy_residual).and_then(of_energy));
    warnings.extend(of_steps(work.unconverged_steps, work.steps));
    warnings.extend(of_extremes(instrument, extremes));
    warnings.extend(of_impacts(events));
    warnings.extend(of_strings(instrument, struck));
    warnings.extend(of_tensions(instrument));
    warnings
}

/// Doubts about the impact on modal strings: too few steps, or steps too long for their partials.
fn of_strings(instrument: &Instrument, struck: &Struck) -> Vec<Warning> {
    let Some(contact) = struck.loudest() else { return Vec::new() };
    let mut warnings = Vec::new();
    if contact.steps < CONTACT_STEPS {
        warnings.push(Warning {
            kind: WarningKind::ContactSteps,
            what: format!(
                "the hammer's contact with the strings at {} took {} steps; expected at least {CONTACT_STEPS}. Try a smaller step",
                instant(contact.since_s),
                contact.steps
            ),
            part: None,
            value: f64::from(contact.steps),
            bound: f64::from(CONTACT_STEPS),
            unit: "steps",
            time_s: Some(contact.since_s),
        });
    }
    let reach_hz = 0.5 / contact.longest_s;
    let beyond = |string: &PianoString| string.partials_below(REACH_HZ) - string.partials_below(REACH_HZ.min(reach_hz));
    let count: u32 = instrument.strings.iter().map(beyond).sum();
    if count > 0 {
        warnings.push(Warning {
            kind: WarningKind::PartialsBeyondStep,
            what: format!(
                "{count} partials of the strings lie between {} Hz and 20 kHz, too high to be resolved by steps of {} us. Try a smaller step",
                rounded(reach_hz),
                rounded(contact.longest_s * 1e6)
            ),
            part: None,
            value: f64::from(count),
            bound: 0.0,
            unit: "partials",
            time_s: Some(contact.since_s),
        });
    }
    warnings
}

/// Doubts about the fastest impact.
#[must_use]
pub fn of_impacts(events: &Events) -> Option<Warning> {
    let fastest = events.impacts.iter().max_by(|a, b| a.hammer_speed_m_per_s.total_cmp(&b.hammer_speed_m_per_s))?;
    (fastest.hammer_speed_m_per_s > HAMMER_SPEED_M_PER_S).then(|| Warning {
        kind: WarningKind::HammerSpeed,
        what: format!(
            "the hammer reaches the string with {} m/s at {}; real hammers reach at most {} m/s",
            rounded(fastest.hammer_speed_m_per_s),
            instant(fastest.time_s),
            rounded(HAMMER_SPEED_M_PER_S)
        ),
        part: None,
        value: fastest.hammer_speed_m_per_s,
        bound: HAMMER_SPEED_M_PER_S,
        unit: "m/s",
        time_s: Some(fastest.time_s),
    })
}

/// Doubts about the compression of felts, the turning of bodies and the energy of impacts, and about an instrument that
/// no run is needed for: whose points lie off their bodies.
pub fn of_extremes<'a>(instrument: &'a Instrument, extremes: &'a Extremes) -> impl Iterator<Item = Warning> + 'a {
    of_felts(instrument, extremes)
        .chain(of_turns(instrument, extremes))
        .chain(of_rest(instrument, extremes))
        .chain(of_sides(instrument, extremes))
        .chain(of_blow(instrument, extremes))
        .chain(shapes::of_shapes(instrument))
}

/// A hammer faster than the energy can have made it.
fn of_blow(instrument: &Instrument, extremes: &Extremes) -> Option<Warning> {
    let (blow, hammer) = (extremes.blow?, instrument.roles.hammer?);
    let first = instrument.first_piece_of(hammer);
    let pieces = (0..instrument.bodies.len()).filter(|&body| instrument.first_piece_of(body) == first);
    let mass_kg: f64 = pieces.map(|body| instrument.bodies[body].mass_kg).sum();
    let most_m_per_s = blow.at_most_m_per_s(mass_kg);
    (blow.speed_m_per_s > most_m_per_s).then(|| Warning {
        kind: WarningKind::SpeedBeyondEnergy,
        what: format!(
            "the hammer of {} g reaches the string with {} m/s at {}; the {} J that finger, springs, felts and heights have given allow {}. Is its strike point off its body?",
            rounded(mass_kg * 1e3),
            rounded(blow.speed_m_per_s),
            instant(blow.time_s),
            rounded(blow.given_j),
            rounded(most_m_per_s)
        ),
        part: Some(instrument.bodies[hammer].name.clone()),
        value: blow.speed_m_per_s,
        bound: most_m_per_s,
        unit: "m/s",
        time_s: Some(blow.time_s),
    })
}

/// A key that rises above its rest, or a hammer that falls below its own: the side on which nothing drives them.
fn of_sides<'a>(instrument: &'a Instrument, extremes: &'a Extremes) -> impl Iterator<Item = Warning> + 'a {
    let roles = [
        (instrument.roles.key, "front", ["rises", "above"], KEY_ABOVE_REST_M),
        (instrument.roles.hammer, "strike point", ["falls", "below"], HAMMER_BELOW_REST_M),
    ];
    roles.into_iter().zip(&extremes.beyond_rest).filter_map(|((body, point, [moves, side], most_m), furthest)| {
        let (name, beyond_m) = (&instrument.bodies[body?].name, -furthest.value);
        (beyond_m > most_m).then(|| Warning {
            kind: WarningKind::BeyondRest,
            what: format!(
                "the {point} of `{name}` {moves} {} mm {side} its rest at {}; expected at most {}. Is a stop missing?",
                rounded(beyond_m * 1e3),
                instant(furthest.time_s),
                rounded(most_m * 1e3)
            ),
            part: Some(name.clone()),
            value: beyond_m,
            bound: most_m,
            unit: "m",
            time_s: Some(furthest.time_s),
        })
    })
}

/// The body that rests furthest from its drawn position, if that is too far.
fn of_rest(instrument: &Instrument, extremes: &Extremes) -> Option<Warning> {
    let turned = instrument.bodies.iter().zip(&extremes.first);
    let (body, by) = turned.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (by.abs() > REST_RAD).then(|| Warning {
        kind: WarningKind::RestFarFromDrawing,
        what: format!(
            "the body `{}` rests {} degrees from as drawn (at most {}): does the normal of a line point the wrong way?",
            body.name,
            rounded(by.to_degrees()),
            rounded(REST_RAD.to_degrees())
        ),
        part: Some(body.name.clone()),
        value: *by,
        bound: REST_RAD.copysign(*by),
        unit: "rad",
        time_s: None,
    })
}

/// The string with the highest stress, if that exceeds the strength of steel. The core of a wound string is thinner
/// than its mass suggests, so its stress is higher.
fn of_tensions(instrument: &Instrument) -> Option<Warning> {
    let most = |string: &PianoString| STEEL_STRENGTH_PA * string.mass_kg_per_m / STEEL_DENSITY_KG_M3;
    let excess = |string: &&PianoString| string.tension_n / most(string);
    let string = instrument.strings.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)))?;
    (string.tension_n > most(string)).then(|| Warning {
        kind: WarningKind::StringTension,
        what: format!(
            "the string `{}` is pulled by {} N, and steel wire of its mass breaks at {} N at most",
            string.name,
            rounded(string.tension_n),
            rounded(most(string))
        ),
        part: Some(string.name.clone()),
        value: string.tension_n,
        bound: most(string),
        unit: "N",
        time_s: None,
    })
}

/// Doubts about an energy residual.
#[must_use]
pub fn of_energy(residual: f64) -> Option<Warning> {
    // What is not a number is beyond every bound.
    if residual <= ENERGY_RESIDUAL {
        return None;
    }
    Some(Warning {
        kind: WarningKind::EnergyResidual,
        what: format!(
            "the energy balance has an error of {} of the work put in; expected at most {}. Try a smaller step",
            percent(residual),
            percent(ENERGY_RESIDUAL)
        ),
        part: None,
        value: residual,
        bound: ENERGY_RESIDUAL,
        unit: "",
        time_s: None,
    })
}

/// Doubts about unconverged steps.
#[must_use]
pub fn of_steps(unconverged: u64, steps: u64) -> Option<Warning> {
    (unconverged > UNCONVERGED_STEPS).then(|| Warning {
        kind: WarningKind::UnconvergedSteps,
        what: format!("{unconverged} of {steps} steps did not converge. Try a smaller step"),
        part: None,
        value: unconverged as f64,
        bound: UNCONVERGED_STEPS as f64,
        unit: "steps",
        time_s: None,
    })
}

/// Felts that were pressed deeper than they are thick.
fn of_felts<'a>(instrument: &'a Instrument, extremes: &'a Extremes) -> impl Iterator<Item = Warning> + 'a {
    instrument.zones.iter().zip(&extremes.deepest).filter_map(|(zone, deepest)| {
        let thickness_m = zone.felt.thickness_m?;
        (deepest.value > thickness_m).then(|| Warning {
            kind: WarningKind::FeltBeyondThickness,
            what: format!(
                "the felt `{}` is compressed by {} mm at {}, but it is {} mm thick",
                zone.name,
                rounded(deepest.value * 1e3),
                instant(deepest.time_s),
                rounded(thickness_m * 1e3)
            ),
            part: Some(zone.name.clone()),
            value: deepest.value,
            bound: thickness_m,
            unit: "m",
            time_s: Some(deepest.time_s),
        })
    })
}

/// Bodies that turned further than their stops let them.
fn of_turns<'a>(instrument: &'a Instrument, extremes: &'a Extremes) -> impl Iterator<Item = Warning> + 'a {
    instrument.bodies.iter().enumerate().zip(&extremes.turned).filter_map(|((index, body), [lowest, highest])| {
        let [low, high] = body.turn_rad?;
        // The worse of both sides.
        let (furthest, bound) =
            if highest.value - high >= low - lowest.value { (highest, high) } else { (lowest, low) };
        let beyond = furthest.value > high || furthest.value < low;
        if let Some((_, lying)) = instrument.lying().find(|(arm, _)| *arm == index) {
            let lift_m = |rad: f64| instrument.lift_m(index, rad);
            return beyond
                .then(|| of_lift(&instrument.bodies[lying].name, [furthest.value, bound].map(lift_m), furthest));
        }
        beyond.then(|| Warning {
            kind: WarningKind::TurnBeyondStops,
            what: format!(
                "the body `{}` has turned by {} degrees at {}; its stops allow {}. Is a stop missing?",
                body.name,
                rounded(furthest.value.to_degrees()),
                instant(furthest.time_s),
                rounded(bound.to_degrees())
            ),
            part: Some(body.name.clone()),
            value: furthest.value,
            bound,
            unit: "rad",
            time_s: Some(furthest.time_s),
        })
    })
}

/// Doubts about a pivot that has moved this far along its pin; both in m, up positive.
fn of_lift(lying: &str, [lift_m, bound_m]: [f64; 2], furthest: &Furthest) -> Warning {
    Warning {
        kind: WarningKind::LiftBeyondPin,
        what: format!(
            "the pivot of `{lying}` has {} by {} mm at {}; expected at most {}. Is a zone missing that holds it?",
            if lift_m > 0.0 { "risen" } else { "sunk" },
            rounded(lift_m.abs() * 1e3),
            instant(furthest.time_s),
            rounded(bound_m.abs() * 1e3)
        ),
        part: Some(lying.to_owned()),
        value: lift_m,
        bound: bound_m,
        unit: "m",
        time_s: Some(furthest.time_s),
    }
}

/// Counts the warnings of many runs by kind and part, and keeps the worst of each.
pub fn worst_of_each<'a>(warnings: impl IntoIterator<Item = &'a Warning>) -> Vec<(usize, &'a Warning)> {
    let beyond = |w: &Warning| (w.value - w.bound).abs();
    let mut kinds: BTreeMap<(WarningKind, Option<&str>), (usize, &Warning)> = BTreeMap::new();
    for warning in warnings {
        let (count, worst) = kinds.entry((warning.kind, warning.part.as_deref())).or_insert((0, warning));
        *count += 1;
        if beyond(warning) > beyond(worst) {
            *worst = warning;
        }
    }
    kinds.into_values().collect()
}

/// Three digits, as a person writes them.
fn rounded(value: f64) -> String {
    let digits = match value.abs() {
        a if (100.0..1e6).contains(&a) => 0,
        a if (10.0..100.0).contains(&a) => 1,
        a if (1e-2..10.0).contains(&a) => 2,
        0.0 => 0,
        _ => return format!("{value:.2e}"),
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn percent(share: f64) -> String {
    format!("{} %", rounded(share * 100.0))
}

fn instant(time_s: f64) -> String {
    format!("{time_s:.4} s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_a_person_writes_them() {
        for (value, text) in
            [(0.0, "0"), (0.5, "0.5"), (10.0, "10"), (38.4, "38.4"), (1234.5, "1234"), (-31.04, "-31"), (1e9, "1.00e9")]
        {
            assert_eq!(rounded(value), text);
        }
        assert_eq!(percent(0.01), "1 %");
    }

    /// The bound itself is allowed; what is not a number is not.
    #[test]
    fn a_bound_is_allowed_and_what_is_not_a_number_is_not() {
        assert!(of_energy(ENERGY_RESIDUAL).is_none());
        assert!(of_energy(ENERGY_RESIDUAL * 1.001).is_some());
        assert!(of_energy(f64::NAN).is_some() && of_energy(f64::INFINITY).is_some());
        assert!(of_steps(0, 100).is_none() && of_steps(1, 100).is_some());
    }

    /// The names are those of the files.
    #[test]
    fn names_are_those_of_the_files() {
        for kind in [
            WarningKind::EnergyResidual,
            WarningKind::UnconvergedSteps,
            WarningKind::FeltBeyondThickness,
            WarningKind::TurnBeyondStops,
            WarningKind::HammerSpeed,
            WarningKind::SpeedBeyondEnergy,
            WarningKind::BeyondRest,
            WarningKind::PointOffBody,
            WarningKind::ContactSteps,
            WarningKind::PartialsBeyondStep,
            WarningKind::StringTension,
            WarningKind::RestFarFromDrawing,
            WarningKind::NoRest,
            WarningKind::NonFinite,
        ] {
            assert_eq!(format!("\"{}\"", kind.name()), serde_json::to_string(&kind).unwrap());
        }
    }
}
