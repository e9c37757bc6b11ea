//! Weights in grams at the key front and of the parts on the scale, and the equation of balance between them.
//!
//! Down-weight D is the smallest weight on the key front that makes the resting key sink to where let-off begins,
//! up-weight U the largest that the key, let go just before, lifts again; balance weight is their mean and friction
//! weight half their difference. They are found twice: by trial with weights (`trial.rs`), and as the largest force of
//! the press and the smallest of the return of a slow loop between the same places. With the parts' weights, weighed as
//! by a technician,
//!
//! BW + FW + A = KR WW + R SW    (D. C. Stanwood, The New Touchweight Metrology, PTG Journal, June 1996)
//!
//! with A for what springs at the whippen take off, gives the strike-weight ratio R. The lever ratio checks it: speed
//! of a mass at the strike weight's place, with the shank level, over the speed of the key front, by the geometry.
//! Without friction the two are one number at one place. D is decided near rest and U near let-off, where friction that
//! grows with the load is less: BW contains half of the difference ([`KeyWeights::friction_in_balance_g`]), and the
//! trade's R with it.

use super::levers::Levers;
use super::slow_loop::{SlowLoop, first_touch, slow_loop};
use super::trial::{largest_that_is_lifted, smallest_that_sinks};
use super::{MeasureError, NotAnAction};
use erard::Progress;
use erard::grand::{Parts, front_weight_g, pedal_down, strike_weight_g, whippen_assist_g, whippen_weight_g};
use erard::instrument::Instrument;
use erard::player::AtRest;

/// Travel below which a key counts as up, m. Nearer to its rest, its cloths push it.
pub const HOME_M: f64 = 0.5e-3;
/// Distance of the up-weight trial from let-off, m of key travel. The jack does not touch the button there yet.
const BEFORE_LET_OFF_M: f64 = 0.3e-3;
/// Shortest free travel that can be measured, m.
const SHORTEST_WAY_M: f64 = 2.0 * HOME_M;
/// Depth of a slow press in the search for the end of the free travel, m. No key dips deeper.
const DEEP_M: f64 = 0.012;
/// Grams per kilogram.
const G_PER_KG: f64 = 1e3;

/// Down-weight and up-weight of one method, g; `None` if no weight in the tried range makes the key sink, or come up.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Touch {
    /// D.
    pub down_weight_g: Option<f64>,
    /// U.
    pub up_weight_g: Option<f64>,
}

impl Touch {
    /// (D + U) / 2, g.
    #[must_use]
    pub fn balance_weight_g(&self) -> Option<f64> {
        Some(0.5 * (self.down_weight_g? + self.up_weight_g?))
    }

    /// (D - U) / 2, g.
    #[must_use]
    pub fn friction_weight_g(&self) -> Option<f64> {
        Some(0.5 * (self.down_weight_g? - self.up_weight_g?))
    }
}

/// Weights on the key front of an action, with the damper on the string or lifted by the pedal.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyWeights {
    /// Touch weights by trial with weights.
    pub by_weights: Touch,
    /// Touch weights from the slow loop.
    pub by_loop: Touch,
    /// Key travel at the largest force of the loop's press and the smallest of its return, m: the places that decide D
    /// and U.
    pub decided_m: [f64; 2],
    /// The slow loop between rest and just before let-off.
    pub slow: SlowLoop,
}

impl KeyWeights {
    /// Mean of the slow loop's two forces at one place, g.
    #[must_use]
    pub fn balance_weight_at(&self, key_m: f64, gravity_m_per_s2: f64) -> Option<f64> {
        let force = 0.5 * (self.slow.down.force(key_m)? + self.slow.up.force(key_m)?);
        Some(force / gravity_m_per_s2 * G_PER_KG)
    }

    /// Friction contained in the balance weight, g: half of what the friction where D is decided exceeds that where U
    /// is. Friction that grows with the load does, since the levers' ratio is larger near rest, where D is decided.
    /// Read from the slow loop, whose two forces at one place tell them apart; positive where BW is read too high.
    #[must_use]
    pub fn friction_in_balance_g(&self, gravity_m_per_s2: f64) -> Option<f64> {
        // Nearer to its rest the cloths push the key.
        let [down, up] = self.decided_m.map(|key_m| self.balance_weight_at(key_m.max(HOME_M), gravity_m_per_s2));
        Some(self.by_loop.balance_weight_g()? - 0.5 * (down? + up?))
    }
}

/// Weights of the parts on the scale, and the key ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct PartWeights {
    /// Weight of the key's front on the scale, the key level on its balance pin, g.
    pub front_weight_g: f64,
    /// Weight of the strike point on the scale, the hammer on its pin and its shank level, g.
    pub strike_weight_g: f64,
    /// Weight of whippen, jack and repetition lever on the scale at the capstan contact, on the whippen's pin, g.
    pub whippen_weight_g: f64,
    /// Weight at the key front per weight over the capstan's contact.
    pub key_ratio: f64,
    /// What springs at the whippen take off the balance weight, g; 0 without them.
    pub assist_g: f64,
}

/// Lever ratio by the geometry. It falls during the stroke, and the balance weight is the mean of a weight decided near
/// rest and one decided near let-off: `where_weighed` is the mean of the ratios at these two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrikeRatio {
    /// Mean of the ratios where down-weight and up-weight are decided.
    pub where_weighed: f64,
    /// Ratio at rest.
    pub at_rest: f64,
    /// Ratio half-way.
    pub half_way: f64,
    /// Ratio at the beginning of let-off.
    pub at_let_off: f64,
}

/// All weights of an action.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Free travel of the key.
    pub free_way: FreeWay,
    /// Weights with the pedal down, as the trade measures: the damper is out of the key's reach.
    pub pedal_down: KeyWeights,
    /// Weights with the damper on the string; `None` if the key lifts no damper.
    pub dampers_down: Option<KeyWeights>,
    /// Weights of the parts on the scale.
    pub parts: PartWeights,
    /// Lever ratio by the geometry.
    pub strike_ratio: StrikeRatio,
}

impl Weights {
    /// R from the equation of balance with the weights found by trial.
    #[must_use]
    pub fn strike_weight_ratio(&self) -> Option<f64> {
        self.parts.strike_weight_ratio(self.pedal_down.by_weights.balance_weight_g()?)
    }
}

impl PartWeights {
    /// R from the equation of balance at a balance weight.
    #[must_use]
    pub fn strike_weight_ratio(&self, balance_weight_g: f64) -> Option<f64> {
        let top = balance_weight_g + self.front_weight_g + self.assist_g - self.key_ratio * self.whippen_weight_g;
        (self.strike_weight_g != 0.0).then(|| top / self.strike_weight_g)
    }
}

/// Weighs an action.
///
/// # Errors
/// See [`MeasureError`].
pub fn weigh(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Weights, MeasureError> {
    let parts = Parts::of(instrument)?;
    let lifted = pedal_down(instrument, &parts)?.pose(progress)?.into_owned();
    let free_way = free_way(&lifted, &parts, progress)?;
    let dampers_down = match parts.damper {
        Some(_) => Some(on_the_key(instrument, free_way.end_m, progress)?),
        None => None,
    };
    let pedal_down = on_the_key(&lifted, free_way.end_m, progress)?;
    let (parts, strike_ratio) = on_the_scale(instrument, free_way.end_m, pedal_down.decided_m)?;
    Ok(Weights { free_way, pedal_down, dampers_down, parts, strike_ratio })
}

/// Free travel of the key on which its weights are found: from rest to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeWay {
    /// Key travel at its end, m.
    pub end_m: f64,
    /// Whether let-off ends it, as it should: not the hammer at the string or the key at its punching.
    pub let_off: bool,
}

/// Presses the key slowly until jack or lever reaches its stop; in an action out of order, until the hammer blocks
/// against the string or the key is down.
///
/// # Errors
/// If there is no free travel, or the run fails.
pub fn free_way(action: &dyn AtRest, parts: &Parts, progress: &mut Progress<'_>) -> Result<FreeWay, MeasureError> {
    let roles = &action.instrument().roles;
    let zones = parts.let_off_stops.iter().copied().chain(roles.string).chain(roles.key_bottom).collect::<Vec<_>>();
    match first_touch(action, DEEP_M, &zones, progress)? {
        Some((touch, end_m)) if end_m > SHORTEST_WAY_M => {
            Ok(FreeWay { end_m, let_off: touch.iter().any(|zone| parts.let_off_stops.contains(zone)) })
        }
        Some((_, way_m)) => Err(NotAnAction::NoFreeWay { way_m }.into()),
        None => Err(NotAnAction::NoLetOff { depth_m: DEEP_M }.into()),
    }
}

/// Down-weight and up-weight from a slow loop.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LoopWeights {
    /// Largest force of the press, smallest of the return.
    pub touch: Touch,
    /// Key travel at the largest force of the press and the smallest of the return, m.
    pub decided_m: [f64; 2],
    /// The loop between rest and just before let-off.
    pub slow: SlowLoop,
}

/// Finds down-weight and up-weight of an action as it is from a slow loop alone: a tenth of the work of trials with
/// weights.
///
/// # Errors
/// If there is no gravity; errors of the run.
pub(crate) fn by_loop(
    action: &dyn AtRest,
    way_m: f64,
    progress: &mut Progress<'_>,
) -> Result<LoopWeights, MeasureError> {
    let instrument = action.instrument();
    if instrument.gravity_m_per_s2 <= 0.0 {
        return Err(NotAnAction::Weightless.into());
    }
    let turn_m = way_m - BEFORE_LET_OFF_M;
    let grams = |force: f64| force / instrument.gravity_m_per_s2 * G_PER_KG;
    // The loop turns a little deeper than the weights are let go, because friction reverses at its turning point.
    let slow = slow_loop(action, way_m, progress)?;
    let hardest = slow.down.smoothed(0.0, turn_m).max_by(|a, b| a.1.total_cmp(&b.1));
    let weakest = slow.up.smoothed(HOME_M, turn_m).min_by(|a, b| a.1.total_cmp(&b.1));
    let touch = Touch {
        down_weight_g: hardest.map(|(_, force)| grams(force)),
        up_weight_g: weakest.map(|(_, force)| grams(force)),
    };
    let decided_m = [hardest.map_or(0.0, |(key, _)| key), weakest.map_or(turn_m, |(key, _)| key)];
    Ok(LoopWeights { touch, decided_m, slow })
}

/// Finds down-weight and up-weight of an action as it is, with its damper where it is.
///
/// # Errors
/// If there is no gravity; errors of the runs.
pub fn on_the_key(action: &dyn AtRest, way_m: f64, progress: &mut Progress<'_>) -> Result<KeyWeights, MeasureError> {
    let rest = action.pose(progress)?;
    let LoopWeights { touch: by_loop, decided_m, slow } = by_loop(&*rest, way_m, progress)?;
    let turn_m = way_m - BEFORE_LET_OFF_M;
    let gram_n = rest.instrument().gravity_m_per_s2 / G_PER_KG;
    let grams = |force: Option<f64>| force.map(|force| force / gram_n);
    let [down_n, up_n] = [by_loop.down_weight_g, by_loop.up_weight_g].map(|weight| weight.map(|g| g * gram_n));
    let by_weights = Touch {
        down_weight_g: grams(smallest_that_sinks(&rest, turn_m, down_n, progress)?),
        up_weight_g: grams(largest_that_is_lifted(&rest, turn_m, HOME_M, up_n, progress)?),
    };
    Ok(KeyWeights { by_weights, by_loop, decided_m, slow })
}

/// Weighs the parts off the action, without bending, from masses, centres of mass and contacts at rest, and finds the
/// lever ratio by the geometry; `decided_m` are the key travels at which down-weight and up-weight were
/// decided.
///
/// # Errors
/// If the instrument is no grand action, has no equilibrium, or its levers do not reach let-off.
pub fn on_the_scale(
    action: &dyn AtRest,
    way_m: f64,
    decided_m: [f64; 2],
) -> Result<(PartWeights, StrikeRatio), MeasureError> {
    let instrument = &action.instrument().locked();
    let parts = &Parts::of(instrument)?;
    let mut levers = Levers::of(action)?;
    let key_front_m = levers.key_front_m;
    let key_ratio = levers.capstan_m / key_front_m;
    let weights = PartWeights {
        front_weight_g: front_weight_g(instrument, parts, key_front_m)?,
        strike_weight_g: strike_weight_g(instrument, parts)?,
        whippen_weight_g: whippen_weight_g(instrument, parts, levers.whippen_arm_m)?,
        key_ratio,
        assist_g: key_ratio * whippen_assist_g(instrument, parts, levers.whippen_arm_m)?,
    };
    // A mass at the strike weight's place: at the hammer's arm with the shank level.
    let mut ratio = |key_m: f64| {
        levers.ratios(key_m).map(|[_, hammer]| hammer * instrument.roles.hammer_strike_point_m[0] / key_front_m)
    };
    let ratios = StrikeRatio {
        where_weighed: 0.5 * (ratio(decided_m[0])? + ratio(decided_m[1])?),
        at_rest: ratio(0.0)?,
        half_way: ratio(0.5 * way_m)?,
        at_let_off: ratio(way_m)?,
    };
    Ok((weights, ratios))
}
