//! Bench test of the train's compliance: the hammer is blocked half-way to the string, weights are laid on the key, and
//! the travel of the key's front and capstan is read from one weight to the next.
//!
//! The front's travel is the total compliance of felts and bends; the capstan's times the key's leverage is that beyond
//! the key: heel, knuckle and shank. Travels are counted from the first weight, which takes up any play. Weights are
//! only added, so that dry friction and the felts' losses always act in one direction.

use moreau::{HuntCrossley, Settings};
use serde::Serialize;

use super::{MeasureError, NotAnAction};
use erard::Progress;
use erard::grand::{Anatomy, rise_m};
use erard::instrument::{Curve, Felt, Instrument, Vec2};
use erard::player::{AtRest, Input, RestPose};

/// The weights, g.
pub(crate) const WEIGHTS_G: [f64; 6] = [100.0, 200.0, 300.0, 500.0, 700.0, 1000.0];
/// Stiffness of the bar that blocks the hammer, N/m: a thousand times that of the felts.
const BAR_N_PER_M: f64 = 1e7;
/// Damping of the bar, s/m: a hammer arriving at tens of mm/s hardly rebounds.
const BAR_S_PER_M: f64 = 100.0;
/// Step, s.
const STEP_S: f64 = 50e-6;
/// Time to lay down a weight, s.
const LAID_S: f64 = 0.25;
/// Time until it is read, s.
const READ_S: f64 = 0.75;

/// Reading of the bench test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BlockedRow {
    /// Weight on the key's front, g.
    pub weight_g: f64,
    /// Travel of the key's front since the first weight, mm, down positive.
    pub front_mm: f64,
    /// Travel of the capstan since the first weight, mm, up positive; `None` if the key touches no whippen.
    pub back_mm: Option<f64>,
}

/// Runs the bench test: a row for each weight. Pass an instrument whose damper is out of the way.
///
/// # Errors
/// If parts are missing, there is no gravity, the key has no equilibrium, or the work is interrupted.
pub(crate) fn blocked(action: &dyn AtRest, progress: &mut Progress<'_>) -> Result<Vec<BlockedRow>, MeasureError> {
    let instrument = action.instrument();
    if instrument.gravity_m_per_s2 <= 0.0 {
        return Err(NotAnAction::Weightless.into());
    }
    let anatomy = Anatomy::find(instrument)?;
    let capstan = capstan(instrument, &anatomy);
    let rest = action.pose(progress)?;
    let held = with_a_bar(&rest, &anatomy)?;
    let mut action = rest.changed(&held, progress)?.action(Settings::new(STEP_S))?;
    let (mut rows, mut before_n, mut zero) = (Vec::new(), 0.0, None);
    for (index, weight_g) in WEIGHTS_G.into_iter().enumerate() {
        let weight_n = weight_g * 1e-3 * instrument.gravity_m_per_s2;
        for step in 0..(READ_S / STEP_S) as u32 {
            let laid = (f64::from(step) * STEP_S / LAID_S).min(1.0);
            action.step(Input::Force(before_n + (weight_n - before_n) * laid));
        }
        before_n = weight_n;
        let back_m = capstan.map(|(body, point)| action.point(Some(body), point)).transpose()?.map(rise_m);
        let now = (action.reading().key_m, back_m);
        let (front_0, back_0) = *zero.get_or_insert(now);
        rows.push(BlockedRow {
            weight_g,
            front_mm: (now.0 - front_0) * 1e3,
            back_mm: back_m.zip(back_0).map(|(now, before)| (now - before) * 1e3),
        });
        if !progress((index + 1) as f64 / WEIGHTS_G.len() as f64) {
            return Err(erard::run::SimulationError::Interrupted.into());
        }
    }
    Ok(rows)
}

/// The key's contact with the whippen: body and point.
fn capstan(instrument: &Instrument, anatomy: &Anatomy) -> Option<(usize, Vec2)> {
    let is = |body: usize, part: usize| instrument.is_same_part(body, part).is_ok_and(|is_same| is_same);
    instrument.zones.iter().find_map(|zone| {
        let (disc, curve) = (zone.disc_body?, zone.curve_body?);
        let on_curve = match zone.curve {
            Curve::Line { point_m, .. } => point_m,
            Curve::Segment { from_m, to_m, .. } => [0.5 * (from_m[0] + to_m[0]), 0.5 * (from_m[1] + to_m[1])],
            Curve::Disc { center_m, .. } => center_m,
        };
        if is(disc, anatomy.key) && is(curve, anatomy.whippen) {
            Some((disc, zone.disc_center_m))
        } else if is(curve, anatomy.key) && is(disc, anatomy.whippen) {
            Some((curve, on_curve))
        } else {
            None
        }
    })
}

/// Puts a bar in place of the string, half-way between it and the hammer's rest.
fn with_a_bar(rest: &RestPose, anatomy: &Anatomy) -> Result<Instrument, MeasureError> {
    let instrument = rest.instrument();
    let rest = rest.action(Settings::new(STEP_S))?;
    let blow_m = -rest.mechanism().compression(anatomy.string);
    let head_m = instrument.roles.hammer_strike_point_m;
    let [x, y] = rest.point(Some(anatomy.hammer), head_m)?;
    let mut held = instrument.clone();
    held.edit(|held| {
        held.roles.rigid_string = true;
        let string = &mut held.zones[anatomy.string];
        (string.disc_body, string.disc_center_m, string.disc_radius_m) = (Some(anatomy.hammer), head_m, 0.0);
        (string.curve_body, string.curve) = (None, Curve::Line { point_m: [x, y + 0.5 * blow_m], normal: [0.0, -1.0] });
        string.felt = Felt {
            stiffness: BAR_N_PER_M,
            exponent: 1.0,
            loss: HuntCrossley { rate: BAR_S_PER_M }.into(),
            thickness_m: None,
        };
    })?;
    Ok(held)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Felts are compliances in series: a linear heel of half the stiffness adds i W / k to the travel of the capstan
    /// and i times that to the front's, with W the weight on the front and i the key's leverage, whatever the other
    /// felts do.
    #[test]
    fn a_softer_heel_gives_what_the_levers_say() {
        const K: f64 = 4e4;
        let grand = Instrument::builtin("concert-grand-rigid").unwrap();
        let with_heel = |stiffness: f64| {
            let mut own = grand.clone();
            let felt = Felt { stiffness, exponent: 1.0, loss: HuntCrossley { rate: 1.0 }.into(), thickness_m: None };
            let heel = own.zones.iter().position(|zone| zone.name == "capstan_heel").unwrap();
            own.edit(|fields| fields.zones[heel].felt = felt).unwrap();
            let parts = erard::grand::Parts::of(&own).unwrap();
            let rows = blocked(&erard::grand::pedal_down(&own, &parts).unwrap(), &mut |_| true).unwrap();
            *rows.last().unwrap()
        };
        let (stiff, soft) = (with_heel(K), with_heel(0.5 * K));
        let leverage = 1.0 / crate::measure::weights::on_the_scale(&grand, 6e-3, [1e-3, 5e-3]).unwrap().0.key_ratio;
        let newton = (stiff.weight_g - WEIGHTS_G[0]) * 1e-3 * grand.gravity_m_per_s2;
        let back_mm = leverage * newton * (1.0 / (0.5 * K) - 1.0 / K) * 1e3;
        let (front, back) = (soft.front_mm - stiff.front_mm, soft.back_mm.unwrap() - stiff.back_mm.unwrap());
        println!("front {front} mm, {} expected; capstan {back} mm, {back_mm} expected", leverage * back_mm);
        assert!((front / (leverage * back_mm) - 1.0).abs() < 0.03 && (back / back_mm - 1.0).abs() < 0.03);
    }
}
