//! A note as it was played, and its faults.

use erard_midi::Law;

use crate::key::{HOME_M, Posture};
use crate::score::WrittenNote;

/// Smallest deviation from the written instant with which a note counts as late or early, s.
const LATE_S: f64 = 2e-3;
/// Smallest deviation from the written velocity with which a note counts as soft or loud, counts.
const SOFT: f64 = 1.0;

/// The faults of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Fault {
    /// The hammer did not meet the string.
    Silent,
    /// The hammer met the string more than once.
    Twice,
    /// By more than 2 ms.
    Late,
    /// By more than 2 ms.
    Early,
    /// By more than a count of velocity.
    Soft,
    /// By more than a count of velocity.
    Loud,
}

impl Fault {
    /// All of them, in the order of a summary's counts.
    pub const ALL: [Fault; 6] = [Fault::Silent, Fault::Twice, Fault::Late, Fault::Early, Fault::Soft, Fault::Loud];

    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Fault::Silent => "silent",
            Fault::Twice => "twice",
            Fault::Late => "late",
            Fault::Early => "early",
            Fault::Soft => "soft",
            Fault::Loud => "loud",
        }
    }
}

/// Why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// The key was still so far down when the hand had to press, m.
    KeyNotBack {
        /// m.
        key_m: f64,
    },
    /// The jack was not back under the knuckle.
    JackNotBack,
    /// The hammer was still so high, m above its rest.
    HammerNotDown {
        /// m.
        hammer_rise_m: f64,
    },
    /// The back check had not caught the hammer.
    NotChecked,
    /// The piece leaves the hand too little time for so gentle a press.
    NoTime,
    /// The note is within 40 ms of the key's last stroke and was not tried.
    TooSoon,
    /// No hand up to 100 N plays the key this loudly from rest.
    TooLoud {
        /// The hammer's speed at the string that the hand reached, m/s.
        reached_m_per_s: f64,
    },
    /// The softest hand that plays the key is louder.
    TooSoft,
    /// The string is still sounding and shifts the impact: it swings under the felt by more than 0.1 mm from side to
    /// side, m.
    StringSounds {
        /// m.
        swing_m: f64,
    },
    /// The search found no better hand, and nothing of the key's state explains it.
    NotFound,
}

impl Reason {
    /// Names in counts, in the order of [`Summary::reasons`].
    pub const NAMES: [&str; 10] = [
        "key not back",
        "jack not under the knuckle",
        "hammer not down",
        "hammer not checked",
        "no time for so gentle a stroke",
        "within 40 ms of the last stroke",
        "louder than a hand can play it",
        "softer than a hand can play it",
        "string still sounding",
        "no better hand was found",
    ];

    /// Its place in [`Reason::NAMES`].
    fn place(&self) -> usize {
        match self {
            Reason::KeyNotBack { .. } => 0,
            Reason::JackNotBack => 1,
            Reason::HammerNotDown { .. } => 2,
            Reason::NotChecked => 3,
            Reason::NoTime => 4,
            Reason::TooSoon => 5,
            Reason::TooLoud { .. } => 6,
            Reason::TooSoft => 7,
            Reason::StringSounds { .. } => 8,
            Reason::NotFound => 9,
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(Reason::NAMES[self.place()])?;
        match self {
            Reason::KeyNotBack { key_m } => write!(f, ": {:.1} mm down", 1e3 * key_m),
            Reason::HammerNotDown { hammer_rise_m } => write!(f, ": {:.0} mm up", 1e3 * hammer_rise_m),
            Reason::TooLoud { reached_m_per_s } => write!(f, ": at most {reached_m_per_s:.2} m/s"),
            Reason::StringSounds { swing_m } => write!(f, ": {:.1} mm from side to side", 1e3 * swing_m),
            _ => Ok(()),
        }
    }
}

/// A note that was played.
#[derive(Debug, Clone, PartialEq)]
pub struct Played {
    /// The written note.
    pub wanted: WrittenNote,
    /// Instant at which the hand began to press, s.
    pub pressed_s: f64,
    /// Largest force of the hand, N.
    pub force_n: f64,
    /// The first impact: instant, s, and hammer speed, m/s.
    pub impact: Option<[f64; 2]>,
    /// Excess of the loudness over the written velocity, in counts by the score's law.
    pub louder: Option<f64>,
    /// Further impacts before the key was pressed again: instant, s, and hammer speed, m/s.
    pub more_impacts: Vec<[f64; 2]>,
    /// Instant at which the rising key set its damper down, s, and speed of its front, m/s; `None` if it was pressed
    /// again before.
    pub released: Option<[f64; 2]>,
    /// Whether the key had been home and the hammer below the check for 20 ms when the hand began to press.
    pub from_home: bool,
    /// Number of trials.
    pub trials: u32,
    pub(crate) reasons: Vec<Reason>,
    pub(crate) checked: bool,
}

impl Played {
    pub(crate) fn new(wanted: WrittenNote, pressed_s: f64, force_n: f64, posture: &Posture) -> Self {
        let mut reasons = Vec::new();
        if posture.key_m > HOME_M {
            reasons.push(Reason::KeyNotBack { key_m: posture.key_m });
        }
        if !posture.jack_is_back {
            reasons.push(Reason::JackNotBack);
        }
        if posture.hammer_rise_m > 5e-3 {
            reasons.push(Reason::HammerNotDown { hammer_rise_m: posture.hammer_rise_m });
        }
        if !posture.was_checked {
            reasons.push(Reason::NotChecked);
        }
        Played {
            wanted,
            pressed_s,
            force_n,
            impact: None,
            louder: None,
            more_impacts: Vec::new(),
            released: None,
            from_home: posture.was_home(),
            trials: 0,
            reasons,
            checked: true,
        }
    }

    /// A note that was not tried because it comes too soon after the key's last strike.
    pub(crate) fn left_out(wanted: WrittenNote, posture: &Posture) -> Self {
        let mut played = Played::new(wanted, wanted.on_s, 0.0, posture);
        played.reasons.push(Reason::TooSoon);
        played
    }

    /// Delay of the sounded note against the written one, s; negative when it came early.
    #[must_use]
    pub fn late_s(&self) -> Option<f64> {
        self.impact.map(|[time_s, _]| time_s - self.wanted.on_s)
    }

    /// The note with its first impact: instant, s, and speed, m/s.
    pub(crate) fn with_impact(self, impact: Option<[f64; 2]>, law: &Law<'_>) -> Self {
        let counts = |speed: f64| law.velocity(speed).counts();
        let louder = impact.map(|[_, speed]| counts(speed) - counts(self.wanted.speed_m_per_s));
        Played { impact, louder, ..self }
    }

    /// Its faults, the worst first.
    #[must_use]
    pub fn faults(&self) -> Vec<Fault> {
        let Some((late_s, louder)) = self.late_s().zip(self.louder) else { return vec![Fault::Silent] };
        let all = [
            (Fault::Twice, !self.more_impacts.is_empty()),
            (Fault::Late, late_s > LATE_S),
            (Fault::Early, late_s < -LATE_S),
            (Fault::Soft, louder < -SOFT),
            (Fault::Loud, louder > SOFT),
        ];
        all.into_iter().filter(|(_, is_so)| *is_so).map(|(fault, _)| fault).collect()
    }

    /// Conditions of the key that explain a fault; empty without a fault.
    #[must_use]
    pub fn reasons(&self) -> Vec<Reason> {
        let faults = self.faults();
        if faults.is_empty() {
            return Vec::new();
        }
        // How a key at home stood is no reason for a second impact.
        let is_of_stroke = faults == [Fault::Twice] && self.from_home;
        let mut reasons = if is_of_stroke { Vec::new() } else { self.reasons.clone() };
        if faults.contains(&Fault::Twice) && !self.checked && !reasons.contains(&Reason::NotChecked) {
            reasons.push(Reason::NotChecked);
        }
        if reasons.is_empty() && faults != [Fault::Twice] {
            reasons.push(Reason::NotFound);
        }
        reasons
    }
}

/// All notes together.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct Summary {
    /// Notes.
    pub notes: usize,
    /// Notes for which the key was at rest and the hammer below the check for 20 ms before the press.
    pub from_home: usize,
    /// Notes without a fault.
    pub right: usize,
    /// Notes by fault, in the order of [`Fault::ALL`]; one note may have several.
    pub faults: [usize; Fault::ALL.len()],
    /// Largest error of a note from home that sounded: counts of velocity, and s.
    pub home_errors: [f64; 2],
    /// Largest errors of the other notes.
    pub other_errors: [f64; 2],
    /// Notes with a fault by reason, in the order of [`Reason::NAMES`]; one note may have several.
    pub reasons: [usize; Reason::NAMES.len()],
    /// Trials of all notes.
    pub trials: u64,
}

impl Summary {
    /// Of these notes.
    #[must_use]
    pub fn of<'a>(notes: impl IntoIterator<Item = &'a Played>) -> Self {
        let mut all = Summary::default();
        for note in notes {
            let faults = note.faults();
            all.notes += 1;
            all.from_home += usize::from(note.from_home);
            all.right += usize::from(faults.is_empty());
            for fault in faults {
                all.faults[fault as usize] += 1;
            }
            for reason in note.reasons() {
                all.reasons[reason.place()] += 1;
            }
            let errors = if note.from_home { &mut all.home_errors } else { &mut all.other_errors };
            if let Some((late_s, louder)) = note.late_s().zip(note.louder) {
                errors[0] = errors[0].max(louder.abs());
                errors[1] = errors[1].max(late_s.abs());
            }
            all.trials += u64::from(note.trials);
        }
        all
    }
}
