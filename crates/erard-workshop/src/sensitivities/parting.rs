//! The point at which derivatives of two presses with different steps begin to differ.

use erard::gradient::{Followed, SwitchAt};
use erard::instrument::Instrument;
use moreau::{SwitchKind, SwitchingLaw};

/// Velocity derivatives differ if their distance exceeds this share of the largest one.
const PARTED: f64 = 0.1;
/// Switches of one law farther apart than this are different ones, s.
const SAME_INSTANT_S: f64 = 1e-4;

/// A derivative that does not converge.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Indices of quantity and number.
    pub(super) place: [usize; 2],
    /// Quantity.
    pub of: &'static str,
    /// Number.
    pub by: String,
    /// Derivative with the given steps, and with shorter ones, per bare number.
    pub slopes: [f64; 2],
    /// Friction switch from which on the two differ; `None` if the rest has different slopes to the two sides.
    pub event: Option<Event>,
    /// Differences downward and upward, per bare number, with the press's steps; `None` if the number cannot be changed
    /// to both sides.
    pub sides: Option<[f64; 2]>,
    /// Complete description in words.
    pub told: String,
}

/// A switch of friction.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Time of the switch, s.
    pub time_s: f64,
    /// Law that switches; `None` if it could not be identified.
    pub law: Option<SwitchingLaw>,
    /// Kind of the switch.
    pub kind: SwitchKind,
}

impl Event {
    fn of(one: &SwitchAt) -> Self {
        Event { time_s: one.time_s, law: one.switch.law, kind: one.switch.kind }
    }

    /// Describes the switch in words: `at 41.32 ms, where the friction of zone jack_knuckle reverses`.
    pub fn told(&self, instrument: &Instrument) -> String {
        let law = match self.law {
            Some(SwitchingLaw::Pivot(i)) => {
                instrument.bodies.get(i).map_or(String::new(), |body| format!("the pivot of {}", body.name))
            }
            Some(SwitchingLaw::Zone(z)) => {
                instrument.zones.get(z).map_or(String::new(), |zone| format!("the contact {}", zone.name))
            }
            None => "something".to_owned(),
        };
        let does = match self.kind {
            SwitchKind::Sticks => "comes to stick",
            SwitchKind::Reverses => "slides the other way",
            SwitchKind::Unresolved => "switches together with another",
        };
        format!("at {:.2} ms, where {law} {does}", 1e3 * self.time_s)
    }
}

impl Refusal {
    /// Describes the refusal in words. `steps_s`: the two step lengths, s.
    pub(super) fn tell(&self, instrument: &Instrument, steps_s: [f64; 2]) -> String {
        let ([a, b], [h, shorter]) = (self.slopes, steps_s.map(|step| 1e6 * step));
        let (of, by) = (self.of, &self.by);
        let begin = format!("the derivative of {of} by {by} does not converge");
        let why = match &self.event {
            Some(event) => format!(
                "it is {a:.4e} in steps of {h:.4} us and {b:.4e} in steps of {shorter:.4} us, which differ in {}; shorter steps may decide",
                event.told(instrument)
            ),
            None => "the rest position at which the press starts has a different slope on either side".to_owned(),
        };
        let sides = self.sides.map_or_else(String::new, |[below, above]| {
            format!(". Differences give {below:.4e} to below and {above:.4e} to above")
        });
        format!("{begin}: {why}{sides}")
    }
}

/// Returns the switch after which the derivatives in a direction differ between two presses and do not agree again.
pub(super) fn parting(first: &Followed, second: &Followed, direction: usize) -> Option<Event> {
    let (mut parted, mut next) = (None, 0);
    for one in &first.switches {
        let is_twin =
            |other: &SwitchAt| other.switch.law == one.switch.law && (other.time_s - one.time_s).abs() < SAME_INSTANT_S;
        let twin = second.switches[next..].iter().position(is_twin);
        let agree = twin.is_some_and(|at| {
            let other = &second.switches[next + at];
            next += at + 1;
            are_near(one, other, direction)
        });
        match agree {
            true => parted = None,
            false => parted = parted.or(Some(one)),
        }
    }
    parted.or(first.switches.last()).map(Event::of)
}

/// Whether the derivatives of all velocities agree.
fn are_near(one: &SwitchAt, other: &SwitchAt, direction: usize) -> bool {
    let (mut largest, mut apart) = (0.0_f64, 0.0_f64);
    for (a, b) in one.slopes.iter().zip(&other.slopes) {
        largest = largest.max(a[direction].abs()).max(b[direction].abs());
        apart = apart.max((a[direction] - b[direction]).abs());
    }
    apart <= PARTED * largest
}
