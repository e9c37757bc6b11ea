//! Measures all that a technician writes down about an action: the protocol sheet.

use super::blocked::{BlockedRow, blocked};
use super::entries::{Doubt, InertiaNumbers, LoopNumbers, MM_PER_M, Sheet, TimingRow, TouchNumbers};
use super::inertia::{InertiaCurve, inertia};
use super::norms::{Line, flags, norms_key};
use super::range::{Loudness, Softest, double_strike, softest, speed_against_force};
use super::repetition::{PRESS_N, Repetition, repetition};
use super::slow_loop::{SlowLoop, slow_loop};
use super::timing::{Timing, timing};
use super::weights::{FreeWay, HOME_M, KeyWeights, PartWeights, StrikeRatio, free_way, on_the_key, on_the_scale};
use super::{MeasureError, NotAnAction, range};
use crate::cores::{self, do_all, job};
use crate::distances::{self, Distances, Protocol};
use erard::Progress;
use erard::grand::{Parts, pedal_down};
use erard::player::{AtRest, RestPose};

/// Depth of the finger in the punching during the hysteresis loop, m: about six newtons by its softness.
const INTO_PUNCHING_M: f64 = 0.3e-3;

/// Results of the jobs.
#[derive(Default)]
struct Results {
    touch: Option<KeyWeights>,
    damped: Option<KeyWeights>,
    inertia: Option<InertiaCurve>,
    full: Option<Option<Repetition>>,
    half: Option<Option<Repetition>>,
    softest: Option<Option<Softest>>,
    double_strike: Option<f64>,
    loudness: Option<Vec<Loudness>>,
    timing: Option<Vec<Timing>>,
    hysteresis: Option<SlowLoop>,
    hysteresis_damped: Option<SlowLoop>,
    scale: Option<(PartWeights, StrikeRatio)>,
    blocked: Option<Vec<BlockedRow>>,
}

/// Measures an action completely and compares it with the norms of its key ([`norms_key`]). Everything begins at the
/// rest of the action, or of its variants, as played unless it is a pose as drawn ([`erard::player::RestPose`]).
/// `progress` receives the share done, and ends the work by returning false.
///
/// # Errors
/// See [`MeasureError`].
pub fn measure(action: &dyn AtRest, progress: &mut Progress<'_>) -> Result<Sheet, MeasureError> {
    let instrument = action.instrument();
    let parts = Parts::of(instrument)?;
    let rest = &*action.pose(progress)?;
    let lifted = rest.of_variant(&pedal_down(instrument, &parts)?, progress)?;
    // First the quantities needed by all others: a tenth of the work.
    const FIRST: f64 = 0.1;
    let (mut way, mut distances) = (None, None);
    let first = vec![
        job(&mut way, |progress| free_way(&lifted, &parts, progress)),
        job(&mut distances, |progress| Ok(distances::measure(rest, &Protocol::default(), progress)?)),
    ];
    do_all(first, cores::count(), &mut |share| progress(FIRST * share))?;
    let (Some(way), Some(distances)) = (way, distances) else { return Err(MeasureError::Lost) };
    let Some(dip) = distances.dip_m else {
        return Err(NotAnAction::Bottomless.into());
    };

    let mut r = Results::default();
    let deep = dip + INTO_PUNCHING_M;
    let mut jobs = vec![
        job(&mut r.touch, |progress| on_the_key(&lifted, way.end_m, progress)),
        job(&mut r.softest, |progress| softest(rest, progress)),
        job(&mut r.double_strike, |progress| double_strike(rest, progress)),
        job(&mut r.loudness, |progress| speed_against_force(rest, progress)),
        job(&mut r.hysteresis, |progress| slow_loop(&lifted, deep, progress)),
        job(&mut r.full, |progress| repetition(rest, HOME_M, progress)),
        job(&mut r.half, |progress| repetition(rest, 0.5 * dip, progress)),
        job(&mut r.timing, |progress| timing(rest, progress)),
        job(&mut r.inertia, |progress| inertia(rest, way.end_m, progress)),
        job(&mut r.blocked, |progress| blocked(&lifted, progress)),
    ];
    if parts.damper.is_some() {
        jobs.insert(1, job(&mut r.damped, |progress| on_the_key(rest, way.end_m, progress)));
        jobs.push(job(&mut r.hysteresis_damped, |progress| slow_loop(rest, deep, progress)));
    }
    do_all(jobs, cores::count(), &mut |share| progress(FIRST + (1.0 - FIRST) * share))?;
    let decided_m = r.touch.as_ref().ok_or(MeasureError::Lost)?.decided_m;
    r.scale = Some(on_the_scale(rest, way.end_m, decided_m)?);
    if !r.is_whole() {
        return Err(MeasureError::Lost);
    }
    let mut sheet = r.sheet(rest, Some(way), &distances);
    sheet.flags = flags(&sheet);
    Ok(sheet)
}

/// Measurements needed by lines of the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Need {
    Way,
    Distances,
    Touch,
    Damped,
    Scale,
    Inertia,
    Full,
    Half,
    Softest,
    DoubleStrike,
    Hysteresis,
    Blocked,
}

impl Need {
    /// Measurements needed by a line, by its key.
    fn of(key: &str) -> &'static [Need] {
        match key {
            "down_weight_g" | "up_weight_g" | "balance_weight_g" | "friction_weight_g" => &[Need::Touch],
            "by_slow_loop.down_weight_g" | "by_slow_loop.up_weight_g" => &[Need::Touch],
            "let_off_begins_mm" => &[Need::Way],
            "let_off_resistance_N" => &[Need::Way, Need::Distances, Need::Hysteresis],
            "loop_loss_mJ" => &[Need::Hysteresis],
            key if key.starts_with("blocked_") => &[Need::Blocked],
            "repetition_rate_hz" => &[Need::Full],
            "repetition_rate_half_hz" => &[Need::Half],
            key if key.starts_with("dampers_down.") => &[Need::Damped],
            key if key.starts_with("effective_inertia") => &[Need::Inertia],
            key if key.starts_with("softest_") => &[Need::Softest],
            "double_strike_m_per_s" => &[Need::DoubleStrike],
            "front_weight_g" | "strike_weight_g" | "whippen_weight_g" | "key_ratio" => &[Need::Scale],
            key if key.starts_with("strike_weight_ratio") => &[Need::Touch, Need::Scale],
            _ => &[Need::Distances],
        }
    }
}

/// Measures only what the given lines of the sheet need, and returns their values in order. Uses one thread, for
/// callers that measure many actions in parallel.
///
/// # Errors
/// See [`MeasureError`].
pub fn measure_some(
    action: &dyn AtRest,
    lines: &[&Line],
    progress: &mut Progress<'_>,
) -> Result<Vec<Option<f64>>, MeasureError> {
    let needs = |need: Need| lines.iter().any(|line| Need::of(line.key).contains(&need));
    let instrument = action.instrument();
    let parts = Parts::of(instrument)?;
    let by_dip = needs(Need::Half) || needs(Need::Hysteresis);
    let by_way = [Need::Way, Need::Touch, Need::Damped, Need::Scale, Need::Inertia].into_iter().any(needs);
    let rest = &*action.pose(progress)?;
    let lifted = if by_way || needs(Need::Hysteresis) || needs(Need::Blocked) {
        Some(rest.of_variant(&pedal_down(instrument, &parts)?, progress)?)
    } else {
        None
    };
    let distances = if needs(Need::Distances) || by_dip {
        distances::measure(rest, &Protocol::default(), progress)?
    } else {
        Distances::default()
    };
    let way = match &lifted {
        Some(lifted) if by_way => Some(free_way(lifted, &parts, progress)?),
        _ => None,
    };
    let mut r = Results::default();
    if let (Some(way), Some(lifted)) = (way, &lifted) {
        if needs(Need::Touch) || needs(Need::Scale) {
            let touch = on_the_key(lifted, way.end_m, progress)?;
            r.scale = Some(on_the_scale(rest, way.end_m, touch.decided_m)?);
            r.touch = Some(touch);
        }
        if needs(Need::Damped) && parts.damper.is_some() {
            r.damped = Some(on_the_key(rest, way.end_m, progress)?);
        }
        if needs(Need::Inertia) {
            r.inertia = Some(inertia(rest, way.end_m, progress)?);
        }
    }
    if by_dip {
        let Some(dip) = distances.dip_m else { return Err(NotAnAction::Bottomless.into()) };
        if needs(Need::Half) {
            r.half = Some(repetition(rest, 0.5 * dip, progress)?);
        }
        if let Some(lifted) = lifted.as_ref().filter(|_| needs(Need::Hysteresis)) {
            r.hysteresis = Some(slow_loop(lifted, dip + INTO_PUNCHING_M, progress)?);
        }
    }
    if needs(Need::Full) {
        r.full = Some(repetition(rest, HOME_M, progress)?);
    }
    if needs(Need::Softest) {
        r.softest = Some(softest(rest, progress)?);
    }
    if let Some(lifted) = lifted.as_ref().filter(|_| needs(Need::Blocked)) {
        r.blocked = Some(blocked(lifted, progress)?);
    }
    if needs(Need::DoubleStrike) {
        r.double_strike = Some(double_strike(rest, progress)?);
    }
    let sheet = r.sheet(rest, way, &distances);
    Ok(lines.iter().map(|line| (line.value)(&sheet).filter(|value| value.is_finite())).collect())
}

impl Results {
    /// Whether all results are present that every action has.
    fn is_whole(&self) -> bool {
        let Results { touch, inertia, full, half, softest, loudness, timing, hysteresis, blocked, .. } = self;
        let weighed = touch.is_some() && inertia.is_some() && hysteresis.is_some();
        weighed
            && full.is_some()
            && half.is_some()
            && softest.is_some()
            && loudness.is_some()
            && timing.is_some()
            && blocked.is_some()
    }

    /// Makes the sheet, without its flags. Missing measurements are NaN or `None`.
    fn sheet(self, rest: &RestPose, way: Option<FreeWay>, distances: &Distances) -> Sheet {
        let instrument = rest.instrument();
        const NONE: f64 = f64::NAN;
        let (full, half, soft) = (self.full.flatten(), self.half.flatten(), self.softest.flatten());
        let tried = TouchNumbers::from(self.touch.as_ref().map(|touch| touch.by_weights).unwrap_or_default());
        let mm = |metres: Option<f64>| metres.map(|m| m * MM_PER_M);
        let half_way_balance = self
            .touch
            .as_ref()
            .zip(way)
            .and_then(|(touch, way)| touch.balance_weight_at(0.5 * way.end_m, instrument.gravity_m_per_s2));
        let part = |of: fn(&PartWeights) -> f64| self.scale.as_ref().map_or(NONE, |(parts, _)| of(parts));
        let ratio = |of: fn(&StrikeRatio) -> f64| self.scale.as_ref().map_or(NONE, |(_, ratio)| of(ratio));
        let by_weights =
            |bw: Option<f64>| self.scale.as_ref().zip(bw).and_then(|((parts, _), bw)| parts.strike_weight_ratio(bw));
        let share = |of: fn(&InertiaCurve) -> f64| self.inertia.as_ref().map_or(NONE, of);
        let let_off = way.filter(|way| way.let_off);
        let resistance = let_off
            .zip(self.hysteresis.as_ref())
            .and_then(|(way, slow)| let_off_resistance(slow, way.end_m, distances));
        let strokes = self.timing.iter().flatten().map(|t| (format!("{} {}", t.nuance, t.touch_name()), &t.warnings));
        let forces = self.loudness.iter().flatten().map(|l| (format!("{} N", l.force_n), &l.warnings));
        let doubts = strokes.chain(forces).flat_map(|(during, warnings)| {
            warnings.iter().map(move |warning| Doubt { during: during.clone(), warning: warning.clone() })
        });
        let warnings: Vec<Doubt> = doubts.collect();
        Sheet {
            instrument: instrument.name.clone(),
            rest: rest.kind(),
            norms_for_key: norms_key(instrument),
            down_weight_g: tried.down_weight_g,
            up_weight_g: tried.up_weight_g,
            balance_weight_g: tried.balance_weight_g,
            friction_weight_g: tried.friction_weight_g,
            dampers_down: self.damped.map(|key| key.by_weights.into()),
            by_slow_loop: self.touch.as_ref().map(|touch| touch.by_loop).unwrap_or_default().into(),
            front_weight_g: part(|p| p.front_weight_g),
            strike_weight_g: part(|p| p.strike_weight_g),
            whippen_weight_g: part(|p| p.whippen_weight_g),
            key_ratio: part(|p| p.key_ratio),
            friction_in_balance_g: self
                .touch
                .as_ref()
                .and_then(|touch| touch.friction_in_balance_g(instrument.gravity_m_per_s2)),
            assist_g: self.scale.as_ref().map(|(parts, _)| parts.assist_g).filter(|assist_g| *assist_g != 0.0),
            strike_weight_ratio_weights: by_weights(tried.balance_weight_g),
            strike_weight_ratio_weights_half_way: by_weights(half_way_balance),
            strike_weight_ratio_kinematics: ratio(|r| r.where_weighed),
            strike_weight_ratio_kinematics_half_way: ratio(|r| r.half_way),
            strike_weight_ratio_kinematics_at_rest: ratio(|r| r.at_rest),
            strike_weight_ratio_kinematics_at_let_off: ratio(|r| r.at_let_off),
            dip_mm: mm(distances.dip_m),
            blow_mm: mm(distances.blow_m),
            lost_motion_mm: mm(distances.lost_motion_m),
            jack_position_mm: mm(distances.jack_position_m),
            lever_height_mm: mm(distances.lever_height_m),
            let_off_begins_mm: mm(let_off.map(|way| way.end_m)),
            let_off_mm: mm(distances.let_off_m),
            drop_mm: mm(distances.drop_m),
            aftertouch_mm: mm(distances.aftertouch_m),
            check_mm: mm(distances.check_m),
            repetition_rise_mm: mm(distances.repetition_rise_m),
            repetition_spring_m_per_s: distances.repetition_spring_m_per_s,
            damper_start_share: distances.damper_start_share,
            effective_inertia_kg: share(|c| c.half_way.total_kg()),
            effective_inertia_key_kg: share(|c| c.half_way.key_kg),
            effective_inertia_whippen_kg: share(|c| c.half_way.whippen_kg),
            effective_inertia_hammer_kg: share(|c| c.half_way.hammer_kg),
            repetition_rate_hz: full.map(|r| r.rate_hz),
            repetition_rate_half_hz: half.map(|r| r.rate_hz),
            repetition_force_N: PRESS_N,
            softest_force_N: soft.map(|s| s.force_n),
            softest_let_off_speed_m_per_s: soft.and_then(|s| s.flight).map(|f| f.let_off_speed_m_per_s),
            softest_fall_speed_m_per_s: soft.and_then(|s| s.flight).map(|f| f.fall_speed_m_per_s),
            double_strike_m_per_s: self.double_strike,
            let_off_resistance_N: resistance,
            loop_loss_mJ: self.hysteresis.as_ref().map_or(NONE, |slow| slow.lost_j() * 1e3),
            blocked_front_mm: self.blocked.as_ref().and_then(|rows| Some(rows.last()?.front_mm)),
            blocked_back_mm: self.blocked.as_ref().and_then(|rows| rows.last()?.back_mm),
            blocked: self.blocked.unwrap_or_default(),
            dynamic_range: self.loudness.unwrap_or_default(),
            midi_map: range::MIDI_MAP,
            timing: self.timing.iter().flatten().map(TimingRow::from).collect(),
            hysteresis: self.hysteresis.as_ref().map_or(LoopNumbers::default(), LoopNumbers::from),
            hysteresis_dampers_down: self.hysteresis_damped.as_ref().map(LoopNumbers::from),
            inertia: self.inertia.map_or(InertiaNumbers::default(), |curve| InertiaNumbers {
                key_mm: curve.key_m.iter().map(|m| m * MM_PER_M).collect(),
                pedal_down_kg: curve.pedal_down_kg,
                dampers_down_kg: curve.dampers_down_kg,
            }),
            flags: Vec::new(),
            trusted: warnings.is_empty(),
            warnings,
        }
    }
}

/// Largest force between the start of let-off and half a millimetre before the bottom, less that half a millimetre
/// before the start of let-off, N.
fn let_off_resistance(slow: &SlowLoop, begins_m: f64, distances: &Distances) -> Option<f64> {
    let before = slow.down.force(begins_m - HOME_M)?;
    let to_m = distances.dip_m? - HOME_M;
    let most = slow.down.smoothed(begins_m, to_m).map(|(_, force)| force).reduce(f64::max)?;
    Some(most - before)
}
