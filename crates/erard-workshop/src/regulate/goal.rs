//! Goals of a regulation.

use erard::parameter::{Quantity, canonical_name};

use crate::distances::{Distances, Trial};
use crate::measure::norms::{Line, lines};

use Quantity::{Length, Share, Speed};

/// Distance that can be a goal. The order is the trade's order of work: the jack and the lever under the knuckle, the
/// hammer line, the key's dip, let-off, drop, checking, the repetition spring, the damper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Goal {
    /// [`Distances::jack_position_m`].
    JackPosition,
    /// [`Distances::lever_height_m`].
    LeverHeight,
    /// [`Distances::blow_m`].
    Blow,
    /// [`Distances::dip_m`].
    Dip,
    /// [`Distances::let_off_m`].
    LetOff,
    /// [`Distances::drop_m`].
    Drop,
    /// [`Distances::check_m`].
    Check,
    /// [`Distances::repetition_rise_m`].
    RepetitionRise,
    /// [`Distances::repetition_spring_m_per_s`].
    RepetitionSpring,
    /// [`Distances::damper_start_share`].
    DamperStart,
}

/// Properties of a goal.
struct Known {
    name: &'static str,
    quantity: Quantity,
    norm: Option<f64>,
    limits: [f64; 2],
    of: fn(&Distances) -> Option<f64>,
}

const fn known(
    name: &'static str,
    quantity: Quantity,
    norm: Option<f64>,
    limits: [f64; 2],
    of: fn(&Distances) -> Option<f64>,
) -> Known {
    Known { name, quantity, norm, limits, of }
}

/// One row per goal, in the order of [`Goal::ALL`].
const KNOWN: [Known; 10] = [
    known("jack position", Length, Some(1.5e-3), [-2e-3, 6e-3], |d| d.jack_position_m),
    known("lever height", Length, Some(0.1e-3), [-1e-3, 2e-3], |d| d.lever_height_m),
    known("blow", Length, Some(46e-3), [20e-3, 80e-3], |d| d.blow_m),
    known("dip", Length, Some(10e-3), [3e-3, 14e-3], |d| d.dip_m),
    known("let-off", Length, Some(1.5e-3), [0.1e-3, 20e-3], |d| d.let_off_m),
    known("drop", Length, Some(1.5e-3), [0.2e-3, 20e-3], |d| d.drop_m),
    known("check", Length, Some(13.5e-3), [2e-3, 40e-3], |d| d.check_m),
    known("repetition rise", Length, None, [0.5e-3, 40e-3], |d| d.repetition_rise_m),
    known("repetition spring", Speed, Some(0.25), [0.02, 2.0], |d| d.repetition_spring_m_per_s),
    known("damper start", Share, Some(0.5), [0.05, 0.95], |d| d.damper_start_share),
];

/// Goals with their values in m, m/s, or shares.
pub type Specification = Vec<(Goal, f64)>;

impl Goal {
    /// All goals, in the order of work.
    pub const ALL: [Goal; 10] = [
        Goal::JackPosition,
        Goal::LeverHeight,
        Goal::Blow,
        Goal::Dip,
        Goal::LetOff,
        Goal::Drop,
        Goal::Check,
        Goal::RepetitionRise,
        Goal::RepetitionSpring,
        Goal::DamperStart,
    ];

    /// Row of the goal.
    fn known(self) -> &'static Known {
        &KNOWN[self as usize]
    }

    /// Finds a goal by its name, with blanks, hyphens or underscores (`let-off`, `let_off`), in regional words
    /// ([`canonical_name`]) or as readings of `diagnose` are named (`spring`, `damper`).
    pub fn named(name: &str) -> Option<Self> {
        let joined = |name: &str| canonical_name(&name.trim().to_lowercase().replace([' ', '-'], "_"));
        let name = joined(name);
        match name.as_str() {
            "spring" => Some(Goal::RepetitionSpring),
            "damper" => Some(Goal::DamperStart),
            name => Goal::ALL.into_iter().find(|goal| joined(goal.name()) == name),
        }
    }

    /// Name in the trade.
    pub fn name(self) -> &'static str {
        self.known().name
    }

    /// Physical quantity of the goal; a share is one of the dip.
    pub fn quantity(self) -> Quantity {
        self.known().quantity
    }

    /// Default target in the trade, m, m/s, or share; `None` without a norm.
    ///
    /// Dip 10 (published 9.5-11), blow 46 (44-49), let-off 1.5, drop 1.5, check 13.5 (12-15): Brekne 2009, Gillespie et
    /// al. 2011. Jack position 1.5: the jack's rear edge flush with the rear of a knuckle core 3 mm thick. Lever height
    /// 0.1: the jack just below the lever. Damper start 0.5: dampers rise from half stroke. Repetition spring 0.25 m/s:
    /// an estimate; technicians want a brisk rise without a kick and give no number. It is a compromise: with much less
    /// the shipped actions miss strokes at 8 Hz, above about 0.22 m/s a hammer let up slowly from the check reaches the
    /// string, and at 0.3 m/s the concert grand's soft notes strike twice, the second time at 0.24 m/s (`erard regulate
    /// --repetition-spring 300mm/s`).
    pub(crate) fn norm(self) -> Option<f64> {
        self.known().norm
    }

    /// Line of the sheet with its usual range; `None` if the sheet has none.
    pub(super) fn line(self) -> Option<&'static Line> {
        let unit = match self.quantity() {
            Quantity::Speed => "m_per_s",
            Quantity::Share => "share",
            _ => "mm",
        };
        let key = format!("{}_{unit}", self.name().replace([' ', '-'], "_"));
        lines().find(|line| line.key == key)
    }

    /// The trade's complete specification.
    pub fn norms() -> Specification {
        Goal::ALL.into_iter().filter_map(|goal| Some((goal, goal.norm()?))).collect()
    }

    /// Smallest and largest sensible target, m, m/s, or share.
    pub(crate) fn limits(self) -> [f64; 2] {
        self.known().limits
    }

    /// Tolerance of `target`: 0.05 mm, 2 % of a speed, 1 % of the dip; for the lever height, which is a tenth of a
    /// millimetre, 0.02 mm.
    pub(crate) fn tolerance(self, target: f64) -> f64 {
        match self {
            Goal::LeverHeight => 2e-5,
            Goal::RepetitionSpring => 0.02 * target,
            Goal::DamperStart => 0.01,
            _ => 5e-5,
        }
    }

    /// Measured value; `None` if the event does not happen.
    pub fn of(self, distances: &Distances) -> Option<f64> {
        (self.known().of)(distances)
    }

    /// Trial that measures the goal.
    pub(super) fn trial(self) -> Trial {
        match self {
            Goal::LeverHeight => Trial::LiftedHammer,
            Goal::Check | Goal::RepetitionRise | Goal::RepetitionSpring => Trial::MediumBlow,
            _ => Trial::SlowKey,
        }
    }

    /// Value of a missing event: a hammer that is not caught is infinitely low and does not rise; a key without a
    /// bottom is infinitely deep.
    pub(super) fn missing(self) -> f64 {
        match self {
            Goal::RepetitionRise | Goal::RepetitionSpring => 0.0,
            _ => f64::INFINITY,
        }
    }

    /// Goal that must stay met while this one's screw is turned, because the same part determines both.
    pub(super) fn keeps(self) -> Option<Goal> {
        (self == Goal::RepetitionRise).then_some(Goal::Check)
    }
}
