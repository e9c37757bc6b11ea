//! The built-in touches as options: which hand plays, and how loud.

use std::path::Path;

use clap::Args;
use erard::level::{DURATION_S, HandKind, LEVELS, LevelError, MASS_KG, Reference, named};
use erard::parameter::{Bare, Quantity};
use erard::player::{Hand, Joints};
use erard::stroke::{Muscle, Stroke, Touch};
use erard::{Instrument, SimulationError};

use crate::failure::Failure;
use crate::names::{Name, one_of};
use crate::number::number;
use crate::session::Session;

/// A hand that plays, and its level.
#[derive(Debug, Clone, Args)]
pub(crate) struct HandOptions {
    /// Level of the built-in touch: hammer speed at the string of 0.5 (pp), 0.79 (p), 1.99 (mf), 3.15 (f) or 5 m/s (ff)
    /// [default: mf]
    #[arg(long, value_name = "pp|p|mf|f|ff", value_parser = ["pp", "p", "mf", "f", "ff"], conflicts_with = "force_step")]
    pub stroke: Option<String>,
    /// Level as a hammer speed at the string, m/s, e.g. 2m/s
    #[arg(
        long,
        value_name = "M/S",
        value_parser = number(Quantity::Speed, "m/s"),
        allow_negative_numbers = true,
        conflicts_with_all = ["stroke", "force_step", "file"]
    )]
    pub hammer_speed: Option<f64>,
    /// How the hand of a built-in touch begins
    #[arg(long, value_parser = one_of(&TOUCHES), default_value = "pressed")]
    pub touch: Touch,
    /// Mass of the hand at the fingertip, g. With a stroke file or --force-step it puts a hand before the key: its
    /// muscle has that force or follows that motion, and its fingertip presses the key [default: 200]
    #[arg(long, value_name = "GRAMS", num_args = 0..=1, require_equals = true, default_missing_value = "200", value_parser = number(Quantity::Mass, "g"))]
    pub hand: Option<f64>,
    /// Speed of the hand when it reaches the key, m/s. It replaces the level of a built-in touch. With a stroke file or
    /// --force-step it needs --hand
    #[arg(long, value_name = "M/S", value_parser = number(Quantity::Speed, "m/s"), allow_hyphen_values = true, conflicts_with_all = ["stroke", "hammer_speed"])]
    pub hand_speed: Option<f64>,
    /// Joints of the hand's finger, e.g. compliance=0.2mm/N,time=8ms: how far they yield under the fingertip's force,
    /// and how fast (damping over stiffness). `stiff`: not at all. A number that is left out keeps its default. With a
    /// stroke file or --force-step it needs --hand [default: stiff; struck built-in touches 0.2mm/N and 8ms]
    #[arg(long, value_name = "compliance=MM/N,time=MS", value_parser = joints)]
    pub joints: Option<JointsOption>,
}

/// Joints as they were typed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointsOption {
    compliance_m_per_n: Option<f64>,
    retardation_s: Option<f64>,
}

impl JointsOption {
    /// These joints; what was not typed is that of others.
    fn over(self, own: Joints) -> Joints {
        Joints {
            compliance_m_per_n: self.compliance_m_per_n.unwrap_or(own.compliance_m_per_n),
            retardation_s: self.retardation_s.unwrap_or(own.retardation_s),
        }
    }
}

/// Reads `stiff`, or one or two of a compliance and a time with their units.
fn joints(text: &str) -> Result<JointsOption, String> {
    let mut found = JointsOption { compliance_m_per_n: None, retardation_s: None };
    if text.trim() == "stiff" {
        return Ok(JointsOption { compliance_m_per_n: Some(0.0), ..found });
    }
    let expected = "expected `stiff`, or compliance and time, as in compliance=0.2mm/N,time=8ms";
    for part in text.split(',') {
        let (name, value) = part.split_once('=').ok_or_else(|| format!("found `{part}`; {expected}"))?;
        let (quantity, place, most, range) = match name.trim() {
            "compliance" => (Quantity::Compliance, &mut found.compliance_m_per_n, 0.1, "0 to 100 mm/N"),
            "time" => (Quantity::Time, &mut found.retardation_s, 1.0, "0 to 1 s"),
            other => return Err(format!("found `{other}`; {expected}")),
        };
        let value = quantity.read(value, Bare::Refused).map_err(|error| format!("{name}: {error}; {expected}"))?;
        if !(0.0..=most).contains(&value) {
            return Err(format!("{name}: expected {range}"));
        }
        if place.replace(value).is_some() {
            return Err(format!("`{name}` is given twice; {expected}"));
        }
    }
    Ok(found)
}

/// How the hand meets the key.
const TOUCHES: [Name<Touch>; 2] = [
    ("pressed", "The hand rests on the key, then its muscle presses", Touch::Pressed),
    ("struck", "The hand is moving when it reaches the key", Touch::Struck),
];

impl HandOptions {
    /// Another level of the same hand.
    pub(crate) fn with(&self, stroke: Option<String>) -> Self {
        HandOptions { stroke, hammer_speed: None, hand_speed: None, ..self.clone() }
    }

    fn mass_kg(&self) -> f64 {
        self.hand.map_or(MASS_KG, |grams| grams * 1e-3)
    }

    /// The joints that were typed; what was not typed is that of others.
    fn joints_over(&self, own: Joints) -> Joints {
        self.joints.map_or(own, |typed| typed.over(own))
    }

    /// Refuses a mass that was read as the stroke's file because the `=` before it is missing.
    pub(crate) fn refuse_mass_as(&self, file: &Path) -> Result<(), Failure> {
        let text = file.to_string_lossy();
        if self.hand.is_some() && number(Quantity::Mass, "g")(&text).is_ok() && !file.exists() {
            return Err(Failure::Usage(format!("--hand {text}: the mass follows an equals sign, --hand={text}")));
        }
        Ok(())
    }

    /// The hand between a file or a force and the key, where one was asked for.
    pub(crate) fn between(&self) -> Result<Option<Hand>, Failure> {
        let Some(grams) = self.hand else {
            let of_a_hand = [("--hand-speed", self.hand_speed.is_some()), ("--joints", self.joints.is_some())];
            return match of_a_hand.into_iter().find(|(_, is_given)| *is_given) {
                Some((option, _)) => {
                    Err(Failure::Usage(format!("{option} with a file, --force-step or --drive needs --hand")))
                }
                None => Ok(None),
            };
        };
        let start_m_per_s = self.hand_speed.unwrap_or(0.0);
        let joints = self.joints_over(Joints::STIFF);
        let hand = Hand { mass_kg: grams * 1e-3, start_m_per_s, joints, ..Hand::default() };
        hand.check().map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Some(hand))
    }

    /// The built-in touch, its level found on this instrument.
    pub(crate) fn touch(&self, session: &mut Session, reference: &Instrument) -> Result<Stroke, Failure> {
        let mut progress = session.progress("finding the hand");
        let stroke = self.touch_with(reference, &mut |share| progress.tell(share)).map_err(|error| match error {
            LevelError::Interrupted => Failure::Simulation(SimulationError::Interrupted),
            error => Failure::Usage(told(&error)),
        })?;
        let hand = described(&stroke).unwrap_or_default();
        session.provenance.used("stroke", &format!("{}: {hand}", stroke.title), None, exact(&stroke).as_bytes());
        Ok(stroke)
    }

    /// The same, before a progress of one's own.
    pub(crate) fn touch_with(
        &self,
        reference: &Instrument,
        progress: &mut erard::Progress<'_>,
    ) -> Result<Stroke, LevelError> {
        let touch = if self.hand_speed.is_some() { Touch::Struck } else { self.touch };
        let kind = HandKind { joints: self.joints_over(touch.joints()), ..HandKind::new(touch, self.mass_kg()) };
        let mut reference = Reference::new(reference, progress)?;
        let (name, found) = match self.hand_speed {
            Some(speed_m_per_s) => {
                (format!("arriving with {speed_m_per_s} m/s"), reference.strike(kind, speed_m_per_s, progress)?.whole())
            }
            None => {
                let level = self.stroke.as_deref().unwrap_or("mf");
                let (name, speed_m_per_s) = match self.hammer_speed {
                    Some(speed_m_per_s) => (format!("{speed_m_per_s} m/s"), speed_m_per_s),
                    None => (level.to_owned(), named(level).unwrap_or(LEVELS[2].1)),
                };
                (name, reference.solve(kind, speed_m_per_s, progress)?.whole())
            }
        };
        let mass = self.hand.map_or_else(String::new, |grams| format!(", hand of {grams} g"));
        let joints = self.joints.map_or_else(String::new, |_| format!(", joints {}", yielding(kind.joints)));
        Ok(Stroke::by_hand(format!("{name}, {}{mass}{joints}", touch.name()), found, DURATION_S))
    }
}

/// The error, with the way out.
fn told(error: &LevelError) -> String {
    let way = match error {
        LevelError::Silent { .. } => ": --drive force or --force-step plays without a level",
        LevelError::OutOfReach { .. } | LevelError::Jump { .. } => ": ask for another --hammer-speed or --hand",
        LevelError::Arrival { .. } => " (--hand-speed)",
        LevelError::Speed { .. } => " (--hammer-speed)",
        LevelError::Hand(_) => " (--hand)",
        _ => "",
    };
    format!("{error}{way}")
}

/// Joints in words.
fn yielding(joints: Joints) -> String {
    let Joints { compliance_m_per_n, retardation_s } = joints;
    let rounded = |value: f64| (value * 1e6).round() / 1e3;
    if compliance_m_per_n == 0.0 {
        return "stiff".to_owned();
    }
    format!("{} mm/N in {} ms", rounded(compliance_m_per_n), rounded(retardation_s))
}

/// What plays, to the last digit: mass, kg, speed of arrival, m/s, the muscle's force, N, the impact, s, and joints
/// that yield, m/N and s.
fn exact(stroke: &Stroke) -> String {
    let Some(played) = stroke.hand_stroke() else { return String::new() };
    let force_n = match played.muscle {
        Muscle::Swells { force_n, .. } | Muscle::Steady { force_n } => force_n,
        _ => f64::NAN,
    };
    let impact_s = played.relaxes.map_or(f64::NAN, |relax| relax.at_s);
    let Joints { compliance_m_per_n, retardation_s } = played.hand.joints;
    let joints =
        if compliance_m_per_n == 0.0 { String::new() } else { format!(" {compliance_m_per_n} {retardation_s}") };
    format!("{} {} {force_n} {impact_s}{joints}", played.hand.mass_kg, played.hand.start_m_per_s)
}

/// What plays, in a line; `None` where no built-in touch does.
pub(crate) fn described(stroke: &Stroke) -> Option<String> {
    let played = stroke.hand_stroke()?;
    let grams = (played.hand.mass_kg * 1e4).round() / 10.0;
    let joints = match played.hand.joints {
        Joints { compliance_m_per_n: 0.0, .. } => String::new(),
        joints => format!(", joints {}", yielding(joints)),
    };
    Some(match played.muscle {
        Muscle::Swells { force_n, within_s } => {
            format!("{grams} g on the key, muscle {force_n:.2} N within {:.0} ms{joints}", within_s * 1e3)
        }
        Muscle::Steady { force_n } => {
            format!("{grams} g arriving with {:.3} m/s, muscle {force_n:.2} N{joints}", played.hand.start_m_per_s)
        }
        _ => return None,
    })
}
