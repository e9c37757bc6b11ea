//! A stroke ready to drive: the prescribed quantity, its start and its duration.

use std::sync::{Arc, Mutex, PoisonError};

use super::{ForceSeries, HandStroke, NUANCES, PositionOf, PositionSeries, SampleError, Series, Touch};
use crate::instrument::Finger;
use crate::player::{self, Hand, Input};

/// Default duration of a run under a constant force, s.
const CONSTANT_DURATION_S: f64 = 0.6;
/// Time that a run continues after the end of a recording, s: the key comes home and the hammer falls to rest.
const AFTER_RECORDING_S: f64 = 0.3;
/// Time that it continues after the end of a built-in stroke, s.
const AFTER_BUILTIN_S: f64 = 0.2;

/// The prescribed quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Prescribed {
    /// The force on the key.
    Force,
    /// The motion of a soft finger that can only push.
    Motion,
    /// The motion of the key itself.
    Rigid,
}

impl Prescribed {
    /// Its name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Prescribed::Force => "force",
            Prescribed::Motion => "motion",
            Prescribed::Rigid => "rigid",
        }
    }

    /// The drive in words, after what is driven.
    pub const fn driven(self) -> &'static str {
        match self {
            Prescribed::Force => "driven by force",
            Prescribed::Motion => "driven by fingertip motion",
            Prescribed::Rigid => "driven by key motion",
        }
    }

    /// The column of a recording that it needs.
    pub fn column(self) -> &'static str {
        match self {
            Prescribed::Force => "force_N",
            Prescribed::Motion | Prescribed::Rigid => "position_m",
        }
    }
}

/// Why a recording cannot drive in the requested way.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DrivingError {
    /// The prescribed quantity was not recorded.
    #[error("{title}: driving by {} needs a column `{}`; there is none", .drive.name(), .drive.column())]
    Missing {
        /// The stroke.
        title: String,
        /// Requested drive.
        drive: Prescribed,
    },
    /// A force that only pulls.
    #[error(
        "{title}: the force is never above 0, down to {least_n} N: a finger pushes the key down, and cannot pull it up (a sensor of the other sign \
         is turned round, in the command with --invert force)"
    )]
    Pulls {
        /// The stroke.
        title: String,
        /// The smallest force, N.
        least_n: f64,
    },
    /// Without a force the fingertip's position does not determine the key's.
    #[error(
        "{title}: driving the key itself needs its position; found the fingertip's and no force. Add a column `force_N`, or drive by motion"
    )]
    NoKeyPosition {
        /// The stroke.
        title: String,
    },
    /// The position is that of the key's back, and would drive the front.
    #[error(
        "{title}: the position is that of the key's back; expected the key's front or the fingertip's, for a run drives the front. `erard compare` \
         drives the back"
    )]
    KeyBack {
        /// The stroke.
        title: String,
    },
    /// Key and fingertip cannot be computed from each other.
    #[error("{title}: key and fingertip: {error}")]
    Samples {
        /// The stroke.
        title: String,
        /// Reason.
        error: SampleError,
    },
}

/// Action of the player over time, ready to drive a key.
#[derive(Debug)]
pub struct Stroke {
    /// Title in figures and messages.
    pub title: String,
    /// The prescribed quantity.
    pub drive: Prescribed,
    /// First instant, s.
    pub start_s: f64,
    /// Default duration of a run, s.
    pub duration_s: f64,
    /// The hand between stroke and key, and its muscle's action where no series gives it.
    hand: Option<Hand>,
    by_hand: Option<HandStroke>,
    series: Option<Series>,
    /// The series' force, which its drives share.
    force: Option<Arc<ForceSeries>>,
    position_of: PositionOf,
    /// The position that drives a key under this finger.
    worked_out: Mutex<Option<(Finger, Arc<PositionSeries>)>>,
    force_n: f64,
}

/// A recording begins with a force where its first is larger, N.
const PRESSED_N: f64 = 0.05;

impl Stroke {
    /// A constant force from the start on, N.
    pub fn constant(title: String, force_n: f64) -> Self {
        Stroke {
            title,
            drive: Prescribed::Force,
            start_s: 0.0,
            duration_s: CONSTANT_DURATION_S,
            hand: None,
            by_hand: None,
            series: None,
            force: None,
            position_of: PositionOf::Key,
            worked_out: Mutex::default(),
            force_n,
        }
    }

    /// The stroke of a hand, for a duration, s, from the instant 0 on, e.g. a touch found by [`crate::level`].
    pub fn by_hand(title: String, stroke: HandStroke, duration_s: f64) -> Self {
        let (hand, by_hand) = (Some(stroke.hand), Some(stroke));
        Stroke { duration_s, hand, by_hand, ..Stroke::constant(title, 0.0) }
    }

    /// This stroke with a hand between stroke and key: the force becomes that of the muscle, or the muscle follows the
    /// motion.
    #[must_use]
    pub fn through(self, hand: Hand) -> Self {
        Stroke { hand: Some(hand), ..self }
    }

    /// The hand that plays; `None` where the stroke drives the key itself. It belongs into the run's
    /// [`crate::Setup::hand`].
    pub fn hand(&self) -> Option<Hand> {
        self.hand
    }

    /// Stroke of the hand, if a hand plays.
    pub fn hand_stroke(&self) -> Option<&HandStroke> {
        self.by_hand.as_ref()
    }

    /// Name of the drive: `hand`, or the prescribed quantity.
    pub fn drive_name(&self) -> &'static str {
        if self.hand.is_some() { "hand" } else { self.drive.name() }
    }

    /// The drive in words, after what is driven.
    pub fn driven(&self) -> &'static str {
        if self.hand.is_some() { "driven by a hand" } else { self.drive.driven() }
    }

    /// A built-in force curve (`strokes/*.csv`), which drives by its force by default; `None` for an unknown name
    /// ([`NUANCES`]).
    ///
    /// # Errors
    /// See [`DrivingError`].
    pub fn curve(
        nuance: &str,
        touch: Touch,
        drive: Option<Prescribed>,
    ) -> Option<Result<(Self, Option<&'static str>), DrivingError>> {
        let nuance = NUANCES.into_iter().find(|known| *known == nuance)?;
        let title = format!("{nuance}, {}", touch.name());
        Some(Self::of(title, Series::builtin(nuance, touch)?, PositionOf::Key, drive, AFTER_BUILTIN_S))
    }

    /// A recording, and a note if it cannot drive exactly as recorded. By default it drives by its force if it has one,
    /// otherwise by the recorded motion.
    ///
    /// # Errors
    /// See [`DrivingError`].
    pub fn recorded(
        title: String,
        series: Series,
        position_of: PositionOf,
        drive: Option<Prescribed>,
    ) -> Result<(Self, Option<&'static str>), DrivingError> {
        Self::of(title, series, position_of, drive, AFTER_RECORDING_S)
    }

    fn of(
        title: String,
        series: Series,
        position_of: PositionOf,
        drive: Option<Prescribed>,
        after_s: f64,
    ) -> Result<(Self, Option<&'static str>), DrivingError> {
        let own = if position_of == PositionOf::Fingertip { Prescribed::Motion } else { Prescribed::Rigid };
        let drive = drive.unwrap_or(if series.force.is_some() { Prescribed::Force } else { own });
        let missing = match drive {
            Prescribed::Force => series.force.is_none(),
            Prescribed::Motion | Prescribed::Rigid => series.position.is_none(),
        };
        if missing {
            return Err(DrivingError::Missing { title, drive });
        }
        if drive != Prescribed::Force && position_of == PositionOf::KeyBack {
            return Err(DrivingError::KeyBack { title });
        }
        if drive == Prescribed::Force
            && let Some([least_n, most_n]) = series.force.as_ref().map(ForceSeries::range_n)
            && least_n < 0.0
            && most_n <= 0.0
        {
            return Err(DrivingError::Pulls { title, least_n });
        }
        let note = match (drive, position_of) {
            (Prescribed::Motion, PositionOf::Key) if series.force.is_none() => Some(
                "without a recorded force the fingertip's position is unknown; the key's position is used instead (--position fingertip: it is the fingertip's; --drive rigid: play the key's position)",
            ),
            (Prescribed::Motion, PositionOf::Key) if series.begins_with_n() > PRESSED_N => Some(
                "the recording begins with a force on the key: the run starts with the key already pressed, not from rest as recorded (--drive force and --drive rigid start as recorded)",
            ),
            (Prescribed::Rigid, PositionOf::Fingertip) if series.force.is_none() => {
                return Err(DrivingError::NoKeyPosition { title });
            }
            _ => None,
        };
        let (start_s, duration_s) = (series.start_s(), series.end_s() - series.start_s() + after_s);
        Ok((
            Stroke {
                drive,
                start_s,
                duration_s,
                force: series.force.clone().map(Arc::new),
                series: Some(series),
                position_of,
                ..Stroke::constant(title, 0.0)
            },
            note,
        ))
    }

    /// The input of the key over time, s on the stroke's own clock, for a fingertip as soft as the instrument says.
    ///
    /// # Errors
    /// See [`DrivingError`].
    pub fn inputs(&self, finger: &Finger) -> Result<Box<dyn Fn(f64) -> Input + Send>, DrivingError> {
        if let Some(stroke) = self.by_hand {
            return Ok(Box::new(move |t| stroke.input(t)));
        }
        let Some(path) = self.path(finger)? else {
            let constant = self.force_n;
            return Ok(match self.force.clone() {
                Some(force) => Box::new(player::force(ForceSeries::driven(force))),
                None => Box::new(move |_| Input::Force(constant)),
            });
        };
        let position = PositionSeries::driven(path);
        Ok(match self.drive {
            Prescribed::Motion => Box::new(player::motion(position)),
            _ => Box::new(player::rigid(position)),
        })
    }

    /// The recorded motion that drives, for a fingertip as soft as the instrument says; `None` where a force does.
    ///
    /// # Errors
    /// See [`DrivingError`].
    pub fn path(&self, finger: &Finger) -> Result<Option<Arc<PositionSeries>>, DrivingError> {
        match self.drive {
            Prescribed::Force => Ok(None),
            Prescribed::Motion => self.position(PositionOf::Fingertip, finger).map(Some),
            Prescribed::Rigid => self.position(PositionOf::Key, finger).map(Some),
        }
    }

    /// The position of key or fingertip, computed once for all strokes with the same finger; the recorded one where the
    /// other is unknown.
    fn position(&self, wanted: PositionOf, finger: &Finger) -> Result<Arc<PositionSeries>, DrivingError> {
        let mut worked_out = self.worked_out.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, position)) = worked_out.as_ref().filter(|(of, _)| of == finger) {
            return Ok(Arc::clone(position));
        }
        let missing = || DrivingError::Missing { title: self.title.clone(), drive: self.drive };
        let series = self.series.as_ref().ok_or_else(missing)?;
        let other = series
            .position_of(wanted, self.position_of, finger)
            .map_err(|error| DrivingError::Samples { title: self.title.clone(), error })?;
        let position = Arc::new(other.or_else(|| series.position.clone()).ok_or_else(missing)?);
        *worked_out = Some((*finger, Arc::clone(&position)));
        Ok(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recording drives by force where it has one, by the motion of what was recorded where not, and says what it
    /// lacks.
    #[test]
    fn what_drives() {
        let read = |text: &str| Series::parse(text, "test").unwrap();
        let both = read("time_s,force_N,position_m\n0,1,0\n1,2,0.01\n");
        let path = read("time_s,position_m\n0,0\n1,0.01\n");
        let of = |series: &Series, whose, drive| Stroke::recorded("x".into(), series.clone(), whose, drive);
        let (stroke, note) = of(&both, PositionOf::Key, None).unwrap();
        assert_eq!((stroke.drive, stroke.duration_s, note), (Prescribed::Force, 1.0 + AFTER_RECORDING_S, None));
        assert_eq!(stroke.inputs(&Finger::default()).unwrap()(0.5), Input::Force(1.5));
        assert_eq!(of(&path, PositionOf::Key, None).unwrap().0.drive, Prescribed::Rigid);
        assert_eq!(of(&path, PositionOf::Fingertip, None).unwrap().0.drive, Prescribed::Motion);
        assert!(of(&path, PositionOf::Key, Some(Prescribed::Motion)).unwrap().1.is_some());
        // A fingertip that begins with a force has pressed the key down before.
        let (_, note) = of(&both, PositionOf::Key, Some(Prescribed::Motion)).unwrap();
        assert!(note.unwrap().contains("begins with a force"), "{note:?}");
        let free = read("time_s,force_N,position_m\n0,0,0\n1,2,0.01\n");
        assert_eq!(of(&free, PositionOf::Key, Some(Prescribed::Motion)).unwrap().1, None);
        let error = of(&path, PositionOf::KeyBack, None).unwrap_err().to_string();
        assert!(error.contains("that of the key's back") && error.contains("`erard compare`"), "{error}");
        let error = of(&path, PositionOf::Key, Some(Prescribed::Force)).unwrap_err().to_string();
        assert!(error.contains("`force_N`"), "{error}");
        assert!(matches!(
            of(&path, PositionOf::Fingertip, Some(Prescribed::Rigid)),
            Err(DrivingError::NoKeyPosition { .. })
        ));
        assert!(Stroke::curve("mezzo", Touch::Struck, None).is_none());
        let (curve, _) = Stroke::curve("mf", Touch::Struck, None).unwrap().unwrap();
        assert_eq!((curve.title.as_str(), curve.drive, curve.hand()), ("mf, struck", Prescribed::Force, None));
        // A hand says what its muscle does, and who it is.
        let played = HandStroke::pressed(0.2, 4.0);
        let stroke = Stroke::by_hand("a hand".into(), played, 0.5);
        assert_eq!((stroke.drive_name(), stroke.hand()), ("hand", Some(played.hand)));
        assert_eq!(stroke.inputs(&Finger::default()).unwrap()(1.0), Input::Force(4.0));
    }
}
