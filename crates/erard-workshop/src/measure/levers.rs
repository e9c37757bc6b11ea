//! Motion of whippen and hammer with the key until let-off begins, by geometry alone.
//!
//! Key, whippen and hammer are three levers in contact. They start from the equilibrium with friction and felts. A felt
//! keeps its thickness at rest; a contact that is open at rest (a jack just below the knuckle, which the repetition
//! lever carries) is closed first, because the levers work only once that play is taken up. Jack and repetition lever
//! turn with the whippen, as they do until the jack's toe meets its button.
//!
//! Contacts are the engine's own: the whippen is turned until the capstan is compressed as at rest, and the hammer
//! until the knuckle is. The linkage derived from the graph of the same levers (`erard-kinematics`) gives the same
//! ratios; a test compares them.

use std::borrow::Cow;

use moreau::Settings;
use moreau_kernels::{EveryBody, LaneObserver, lane_observer};

use super::{MeasureError, NotAnAction};
use erard::Progress;
use erard::assembly::{describe, probes};
use erard::grand::{Anatomy, Parts};
use erard::player::{ActionError, AtRest, RestPose};

/// Largest key travel per step of the levers, m.
const WAY_M: f64 = 1e-3;
/// Smallest turn of a lever, rad: some rounding errors of a compression over a lever arm.
const STANDS_RAD: f64 = 1e-13;
/// Newton's method needs four or five iterations for a tenth of the stroke.
const MAX_ITERATIONS: usize = 50;

/// Key, whippen and hammer of a grand action, its bends locked.
pub(crate) struct Levers {
    /// Horizontal distance from the key's pivot to the finger, m; positive.
    pub key_front_m: f64,
    /// Horizontal distance from the key's pivot to the capstan's contact at rest, m; positive away from the player.
    pub capstan_m: f64,
    /// Horizontal distance from the whippen's pivot to that contact, m; negative.
    pub whippen_arm_m: f64,
    key: usize,
    /// The whippen with the parts on it.
    whippen: Vec<usize>,
    hammer: usize,
    /// Zones at capstan and knuckle, and the compression that each keeps, m.
    held: [(usize, f64); 2],
    rest: EveryBody,
    observer: Box<dyn LaneObserver>,
}

impl Levers {
    /// Finds the levers of an instrument. Of several zones between key and whippen the most compressed is the
    /// capstan's.
    ///
    /// # Errors
    /// If the instrument is no grand action, has no equilibrium, or its levers do not reach each other.
    pub(crate) fn of(action: &dyn AtRest) -> Result<Self, MeasureError> {
        let rest = rigid(action, &mut |_| true)?;
        let instrument = rest.instrument();
        let Anatomy { key, hammer, whippen, jack_knuckle, .. } = Anatomy::find(instrument)?;
        let action = rest.action(Settings::new(instrument.usual_step_s()))?;
        let at_rest = action.mechanism();
        let between = |zone: &usize| {
            let zone = &instrument.zones[*zone];
            [(zone.disc_body, zone.curve_body), (zone.curve_body, zone.disc_body)].contains(&(Some(key), Some(whippen)))
        };
        let capstan = (0..instrument.zones.len())
            .filter(between)
            .max_by(|&a, &b| at_rest.compression(a).total_cmp(&at_rest.compression(b)))
            .ok_or(NotAnAction::NoCapstan)?;
        let pivot_m = |body: usize| at_rest.point(Some(body), [0.0; 2])[0];
        let key_front_m = pivot_m(key) - at_rest.point(Some(key), instrument.roles.key_front_m)[0];
        if key_front_m <= 0.0 {
            return Err(NotAnAction::FingerBehindPivot.into());
        }
        let mut rest = [0.0; _];
        rest.iter_mut().zip(at_rest.readout().angles).for_each(|(rest, angle)| *rest = *angle);
        let mut levers = Levers {
            key_front_m,
            capstan_m: 0.0,
            whippen_arm_m: 0.0,
            key,
            whippen: Parts::riders(instrument, whippen).collect(),
            hammer,
            held: [capstan, jack_knuckle].map(|zone| (zone, at_rest.compression(zone).max(0.0))),
            rest,
            observer: lane_observer(&describe(instrument), &probes(instrument)).map_err(ActionError::from)?,
        };
        levers.close(&mut rest).ok_or(NotAnAction::ShortLevers)?;
        levers.rest = rest;
        let [touches_m, _] = levers.observer.contact_point(capstan);
        (levers.capstan_m, levers.whippen_arm_m) = (touches_m - pivot_m(key), touches_m - pivot_m(whippen));
        Ok(levers)
    }

    /// Angular velocities of whippen and hammer over the key's, at a travel of the key's front along its arc.
    ///
    /// # Errors
    /// If the levers do not reach so far.
    pub(crate) fn ratios(&mut self, key_m: f64) -> Result<[f64; 2], NotAnAction> {
        let mut angles = self.rest;
        let parts = (key_m.abs() / WAY_M).ceil().max(1.0);
        for part in 1..=parts as usize {
            angles[self.key] = self.rest[self.key] + part as f64 / parts * key_m / self.key_front_m;
            self.close(&mut angles).ok_or(NotAnAction::ShortLevers)?;
        }
        let [capstan, knuckle] = self.held.map(|(zone, _)| self.observer.compression_row(zone));
        let whippen = |row: &[f64]| self.whippen.iter().map(|&body| row[body]).sum::<f64>();
        let ratio = -capstan[self.key] / whippen(&capstan);
        Ok([ratio, -whippen(&knuckle) * ratio / knuckle[self.hammer]])
    }

    /// Turns the whippen onto the key and the hammer onto the whippen. `None` if they do not reach each other.
    fn close(&mut self, angles: &mut EveryBody) -> Option<()> {
        let [capstan, knuckle] = self.held;
        turn(&mut *self.observer, angles, &self.whippen, capstan)?;
        turn(&mut *self.observer, angles, &[self.hammer], knuckle)
    }
}

/// Where an action rests without its bends, which are locked.
pub(super) fn rigid<'a>(action: &'a dyn AtRest, progress: &mut Progress<'_>) -> Result<Cow<'a, RestPose>, ActionError> {
    if action.instrument().has_bends() {
        return RestPose::of(&action.instrument().locked(), action.kind(), progress).map(Cow::Owned);
    }
    action.pose(progress)
}

/// Turns bodies together until a zone is compressed by `held_m`.
fn turn(
    observer: &mut dyn LaneObserver,
    angles: &mut EveryBody,
    bodies: &[usize],
    (zone, held_m): (usize, f64),
) -> Option<()> {
    for _ in 0..MAX_ITERATIONS {
        observer.update(0.0, angles, &[0.0; _]);
        let row = observer.compression_row(zone);
        let arm_m: f64 = bodies.iter().map(|&body| row[body]).sum();
        let by = (held_m - observer.compression(zone)) / arm_m;
        bodies.iter().for_each(|&body| angles[body] += by);
        if by.abs() < STANDS_RAD {
            observer.update(0.0, angles, &[0.0; _]);
            return Some(());
        }
    }
    None
}
