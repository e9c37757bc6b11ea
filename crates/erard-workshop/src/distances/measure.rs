//! Distances of a regulated action, measured as a technician does.
//!
//! The action has been played once before ([`erard::player::RestPose`]). Two trials with the key give all but the lever
//! height, which is read with the hammer lifted. Slow key: pressed from rest at a few millimetres a second until the
//! hammer is let off, held there until the hammer has dropped, then pressed firmly to the bottom. Medium blow: a
//! constant force throws the hammer at the string at about mf; the back check catches the hammer, then the key is let
//! up slowly until the check lets go, and held there while the repetition spring lifts the hammer.

use super::fixture::{DistanceError, Fixture, Still};
use erard::Progress;
use erard::grand::{Anatomy, rise_m};
use erard::instrument::{Curve, Instrument, Vec2};
use erard::player::{AtRest, RestPose};

/// Protocol of the presses. The default is the project's; a workshop with other habits can set its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Protocol {
    /// Speed of the slow finger, m/s: slow enough that the hammer's swing on its felts changes no distance by more than
    /// 0.02 mm.
    pub slow_m_per_s: f64,
    /// Force of the firm press for the dip, N: half a kilogram of finger.
    pub firm_n: f64,
    /// Force of the medium blow, N, applied at once and held: the hammer reaches the string at about 2 m/s, mf.
    pub blow_n: f64,
    /// Step of the slow trial, s.
    pub slow_step_s: f64,
    /// Step of the medium blow, s.
    pub blow_step_s: f64,
}

impl Default for Protocol {
    fn default() -> Self {
        Protocol { slow_m_per_s: 2e-3, firm_n: 5.0, blow_n: 4.0, slow_step_s: 2e-4, blow_step_s: 5e-5 }
    }
}

/// Distances, SI units; `None` if the event did not happen or the instrument has no such part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct Distances {
    /// Dip: travel of the key front from rest to the bottom under a firm press ([`Protocol::firm_n`]), m.
    pub dip_m: Option<f64>,
    /// Blow: strike point to string with the action at rest, m.
    pub blow_m: Option<f64>,
    /// Lost motion: travel of the key front before the hammer has risen by `MOVED_M`, m.
    pub lost_motion_m: Option<f64>,
    /// Let-off: nearest approach of the strike point to the string on a slow key, m. Zero or negative if the hammer
    /// blocks against the string: minus the compression of the string's felt.
    pub let_off_m: Option<f64>,
    /// Drop: fall of the strike point from its nearest approach to where it rests on the repetition lever, with the key
    /// held at let-off, m. 0 if it does not fall.
    pub drop_m: Option<f64>,
    /// Aftertouch: travel of the key front from the hammer's highest point at let-off to the bottom, m; `None` without
    /// let-off.
    pub aftertouch_m: Option<f64>,
    /// Jack position: from the middle of the knuckle to the rear edge of the jack's top, along the jack's top, at rest,
    /// m. Positive: the knuckle sits on the jack.
    pub jack_position_m: Option<f64>,
    /// Lever height: step from the jack's top up to the repetition lever's, under the knuckle, with the hammer lifted
    /// off, m. Positive: the jack is lower and slips back freely.
    pub lever_height_m: Option<f64>,
    /// Damper timing: travel of the key front when the damper has risen by `MOVED_M`, as a share of the dip.
    pub damper_start_share: Option<f64>,
    /// Check distance: strike point to string with the hammer caught by the back check after a medium blow, m, or after
    /// a harder one if that one leaves it uncaught. `None` if it is caught after none of them.
    pub check_m: Option<f64>,
    /// Repetition rise: rise of the strike point from where it was caught to where it comes to rest, when the key is
    /// let up slowly until the back check lets go, and is held there, m. Not positive if the spring cannot lift the
    /// hammer.
    pub repetition_rise_m: Option<f64>,
    /// Strength of the repetition spring: largest speed of the strike point during that rise, m/s. Technicians judge it
    /// by eye: a brisk rise that can be followed, without a jump.
    pub repetition_spring_m_per_s: Option<f64>,
    /// Steps of the trials that reached an iteration limit.
    pub unconverged_steps: u64,
}

/// Travel from rest at which a technician sees that a part has moved, m.
pub(crate) const MOVED_M: f64 = 1e-4;

/// Fall from its highest point that shows that the hammer is let off, m: a fifth of a usual drop, ten times the
/// hammer's swing on its felts under a slow finger.
const LET_OFF_FALL_M: f64 = 2e-4;
/// Greatest depth of a slow finger, m: a quarter more than the deepest key.
const DEEPEST_M: f64 = 15e-3;
/// Longest time for a hammer to drop, s: several swings.
const DROP_S: f64 = 1.5;
/// Longest time from the first touch of a medium blow until the hammer hangs in the check, s.
const BLOW_S: f64 = 0.5;
/// Strengths of medium blows, of the protocol's: a check that does not catch the hammer is tried with harder ones, as a
/// technician plays again. Where it hardly holds, a little decides: sample 14, put out of order and worked on, checks
/// after 4.25 and 5.5 N, each time at 12.2 mm, and not after 4 and 4.5 N.
const HARDER: [f64; 5] = [1.0, 1.125, 1.25, 1.375, 1.5];
/// Longest time for a hammer to rise from the check, s.
const RISE_S: f64 = 1.0;
/// A hammer is at rest if it has been slower than this, m/s, for [`STILL_S`].
const STILL_M_PER_S: f64 = 2e-4;
/// Duration of rest, s.
const STILL_S: f64 = 0.03;

/// Trial of the action. Each starts from rest and gives some of the distances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trial {
    /// Pressed slowly, held at let-off, pressed on to the bottom.
    SlowKey,
    /// The hammer lifted off jack and lever to read their heights.
    LiftedHammer,
    /// Struck at about mf, checked, let up slowly from the check.
    MediumBlow,
}

impl Trial {
    /// All trials.
    pub(crate) const ALL: [Trial; 3] = [Trial::SlowKey, Trial::LiftedHammer, Trial::MediumBlow];

    /// Makes the trial and sets its distances, leaving the others as they are; unconverged steps are added up.
    ///
    /// # Errors
    /// See [`DistanceError`].
    pub(crate) fn run(
        self,
        rest: &RestPose,
        protocol: &Protocol,
        distances: &mut Distances,
        progress: &mut Progress<'_>,
    ) -> Result<(), DistanceError> {
        let anatomy = Anatomy::find(rest.instrument())?;
        match self {
            Trial::SlowKey => slow_key(rest, anatomy, protocol, distances, progress),
            Trial::LiftedHammer => lifted_hammer(rest, anatomy, protocol, distances, progress),
            Trial::MediumBlow => medium_blow(rest, anatomy, protocol, distances, progress),
        }
    }
}

/// Measures all distances in three trials. `progress` ends the work by returning false.
///
/// # Errors
/// See [`DistanceError`]. A distance that cannot be measured is no error: it is `None`.
pub fn measure(
    action: &dyn AtRest,
    protocol: &Protocol,
    progress: &mut Progress<'_>,
) -> Result<Distances, DistanceError> {
    Anatomy::find(action.instrument())?;
    let rest = action.pose(progress)?;
    let mut distances = Distances::default();
    for trial in Trial::ALL {
        trial.run(&rest, protocol, &mut distances, progress)?;
    }
    Ok(distances)
}

/// Slow key: blow, lost motion, jack position, let-off, drop, aftertouch, dip, damper timing.
fn slow_key(
    rest: &RestPose,
    anatomy: Anatomy,
    protocol: &Protocol,
    distances: &mut Distances,
    progress: &mut Progress<'_>,
) -> Result<(), DistanceError> {
    let instrument = rest.instrument();
    let mut fixture = Fixture::at_rest(rest, anatomy, protocol.slow_step_s)?;
    let rest_m = fixture.view().below_string_m;
    let damper_height = |fixture: &Fixture<'_>| {
        anatomy.damper.map(|d| rise_m(fixture.point(Some(d), instrument.bodies[d].center_of_mass_m)))
    };
    let damper_rest = damper_height(&fixture);
    distances.blow_m = Some(rest_m);
    distances.jack_position_m = jack_position(instrument, &anatomy, &fixture);

    let (mut lost, mut damper) = (None, None);
    let (mut nearest_m, mut nearest_key_m) = (rest_m, 0.0);
    let mut toe_seen = false;
    let mut follow = |fixture: &Fixture<'_>| {
        let view = fixture.view();
        if rest_m - view.below_string_m > MOVED_M {
            lost.get_or_insert(view.key_m);
        }
        if let (Some(height), Some(rest)) = (damper_height(fixture), damper_rest)
            && height - rest > MOVED_M
        {
            damper.get_or_insert(view.key_m);
        }
        view
    };
    let at_bottom =
        |fixture: &Fixture<'_>, force_n: f64| fixture.compression(anatomy.punching) > 0.0 && force_n >= protocol.firm_n;

    let mut dip_m = None;
    let let_off = fixture.move_finger(
        protocol.slow_m_per_s,
        DEEPEST_M,
        &mut |fixture| {
            let view = follow(fixture);
            toe_seen |= fixture.compression(anatomy.button) > 0.0;
            if view.below_string_m < nearest_m {
                (nearest_m, nearest_key_m) = (view.below_string_m, view.key_m);
            }
            if at_bottom(fixture, view.force_n) {
                dip_m = Some(view.key_m);
            }
            dip_m.is_some() || (toe_seen && view.below_string_m > nearest_m + LET_OFF_FALL_M)
        },
        progress,
    )? && dip_m.is_none();
    if let_off {
        let mut still = Still::new(STILL_M_PER_S, STILL_S);
        fixture.hold(
            DROP_S,
            &mut |fixture| {
                follow(fixture);
                still.seen(fixture)
            },
            progress,
        )?;
        distances.drop_m = Some(fixture.view().below_string_m - nearest_m);
        fixture.move_finger(
            protocol.slow_m_per_s,
            DEEPEST_M,
            &mut |fixture| {
                let view = follow(fixture);
                if at_bottom(fixture, view.force_n) {
                    dip_m = Some(view.key_m);
                }
                dip_m.is_some()
            },
            progress,
        )?;
        distances.aftertouch_m = dip_m.map(|dip| dip - nearest_key_m);
    } else {
        (distances.drop_m, distances.aftertouch_m) = (Some(0.0), None);
    }
    distances.let_off_m = Some(nearest_m);
    distances.lost_motion_m = lost;
    distances.dip_m = dip_m;
    distances.damper_start_share = damper.zip(dip_m).map(|(start, dip)| start / dip);
    distances.unconverged_steps += fixture.unconverged;
    Ok(())
}

/// Rear edge of the jack's top and the direction along it to the back, in the jack's frame; `None` if it has no end.
fn jack_edge(instrument: &Instrument, anatomy: &Anatomy, fixture: &Fixture<'_>) -> Option<(Vec2, Vec2)> {
    let zone = &instrument.zones[anatomy.jack_knuckle];
    let Curve::Segment { from_m, to_m, .. } = zone.curve else { return None };
    let [from, to] = [from_m, to_m].map(|point| fixture.point(zone.curve_body, point));
    let (front, rear) = if from[0] < to[0] { (from, to) } else { (to, from) };
    let along = [rear[0] - front[0], rear[1] - front[1]];
    let length = along[0].hypot(along[1]);
    Some((rear, along.map(|a| a / length)))
}

fn jack_position(instrument: &Instrument, anatomy: &Anatomy, fixture: &Fixture<'_>) -> Option<f64> {
    let zone = &instrument.zones[anatomy.jack_knuckle];
    let Curve::Segment { rounding_m, .. } = zone.curve else { return None };
    let (rear, along) = jack_edge(instrument, anatomy, fixture)?;
    let knuckle = fixture.point(zone.disc_body, zone.disc_center_m);
    Some((rear[0] - knuckle[0]) * along[0] + (rear[1] - knuckle[1]) * along[1] + rounding_m)
}

/// Step between jack and repetition lever, with the hammer lifted off both.
fn lifted_hammer(
    rest: &RestPose,
    anatomy: Anatomy,
    protocol: &Protocol,
    distances: &mut Distances,
    progress: &mut Progress<'_>,
) -> Result<(), DistanceError> {
    let instrument = rest.instrument();
    distances.lever_height_m = None;
    let Some(lever_knuckle) = anatomy.lever_knuckle else { return Ok(()) };
    // A knuckle without leather touches neither: the hammer lies on its rest, as far away as possible.
    let mut lifted = instrument.clone();
    for zone in [anatomy.jack_knuckle, lever_knuckle] {
        lifted.edit(|fields| fields.zones[zone].felt.remove())?;
    }
    let lifted = rest.changed(&lifted, progress)?;
    let fixture = Fixture::at_rest(&lifted, anatomy, protocol.slow_step_s)?;
    let (jack, lever) = (&instrument.zones[anatomy.jack_knuckle], &instrument.zones[lever_knuckle]);
    let (Curve::Segment { rounding_m, .. }, Curve::Line { point_m, normal }) = (jack.curve, lever.curve) else {
        return Ok(());
    };
    let Some((rear, along)) = jack_edge(instrument, &anatomy, &fixture) else { return Ok(()) };
    let up = [-along[1], along[0]];
    let top = [rear[0] + rounding_m * up[0], rear[1] + rounding_m * up[1]];
    let foot = fixture.point(lever.curve_body, point_m);
    let tip = fixture.point(lever.curve_body, [point_m[0] + normal[0], point_m[1] + normal[1]]);
    let out = [tip[0] - foot[0], tip[1] - foot[1]];
    distances.lever_height_m = Some((foot[0] - top[0]) * out[0] + (foot[1] - top[1]) * out[1]);
    Ok(())
}

/// Medium blow: check distance, repetition rise, strength of the repetition spring.
fn medium_blow(
    rest: &RestPose,
    anatomy: Anatomy,
    protocol: &Protocol,
    distances: &mut Distances,
    progress: &mut Progress<'_>,
) -> Result<(), DistanceError> {
    (distances.check_m, distances.repetition_rise_m, distances.repetition_spring_m_per_s) = (None, None, None);
    let Some(check) = anatomy.check else { return Ok(()) };
    for harder in HARDER {
        let mut fixture = Fixture::at_rest(rest, anatomy, protocol.blow_step_s)?;
        blow_and_let_up(&mut fixture, anatomy, check, harder * protocol.blow_n, protocol, distances, progress)?;
        distances.unconverged_steps += fixture.unconverged;
        if distances.check_m.is_some() {
            break;
        }
    }
    Ok(())
}

fn blow_and_let_up(
    fixture: &mut Fixture<'_>,
    anatomy: Anatomy,
    check: usize,
    blow_n: f64,
    protocol: &Protocol,
    distances: &mut Distances,
    progress: &mut Progress<'_>,
) -> Result<(), DistanceError> {
    let (mut struck, mut still) = (false, Still::new(STILL_M_PER_S, STILL_S));
    fixture.press(
        blow_n,
        BLOW_S,
        &mut |fixture| {
            struck |= fixture.compression(anatomy.string) > 0.0;
            struck && fixture.compression(anatomy.punching) > 0.0 && still.seen(fixture)
        },
        progress,
    )?;
    if fixture.compression(check) <= 0.0 {
        return Ok(());
    }
    let caught_m = fixture.view().below_string_m;
    distances.check_m = Some(caught_m);
    let free =
        fixture.move_finger(-protocol.slow_m_per_s, 0.0, &mut |fixture| fixture.compression(check) <= 0.0, progress)?;
    if !free {
        return Ok(());
    }
    let (mut fastest_m_per_s, mut still) = (0.0_f64, Still::new(STILL_M_PER_S, STILL_S));
    fixture.hold(
        RISE_S,
        &mut |fixture| {
            fastest_m_per_s = fastest_m_per_s.max(fixture.view().rise_m_per_s);
            still.seen(fixture)
        },
        progress,
    )?;
    distances.repetition_rise_m = Some(caught_m - fixture.view().below_string_m);
    distances.repetition_spring_m_per_s = Some(fastest_m_per_s);
    Ok(())
}
