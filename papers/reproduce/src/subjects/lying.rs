//! The key that lies on its balance rail, beside one that is nailed to its pin: the release and rival causes of its two
//! humps, the bench test that would tell them apart, the lift over a whole press, and the energy of the first
//! millimetre. Both keys are made of the given instrument, whichever it has. Nothing is regulated again.

use moreau::{Elastoplastic, Settings};

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::{Bushing, Curve, Felt, Instrument, Spring, Vec2, Zone};
use erard::level::{DURATION_S, HandKind, LET_GO_S, MASS_KG, Reference, named};
use erard::player;
use erard::run::{Run, Setup, press_by_hand, simulate};
use erard::stroke::Touch;
use erard_workshop::validate::release::{Hump, Release, let_go};

/// Zone on which the key lies, and the one between capstan and heel.
const RAIL: &str = "balance_rail";
const HEEL: &str = "capstan_heel";
/// Punching under a key whose file has none, N/m2, and its loss: 0.11 mm under 25 N, the number that the comment of the
/// capstan's heel has. Estimates.
const PUNCHING_N_PER_M2: f64 = 1.33e9;
const PUNCHING: Elastoplastic<f64> = Elastoplastic { damping: 2.6e8, eta: 0.5, slip: 0.1 };
/// The heel alone is stiffer by this than heel and punching in series, which a nailed key has.
const HEEL_ALONE: f64 = 1.1 / 0.51;
/// Friction along the pins of a key whose file has none, N. An estimate; new bushings can hold a key up.
const PIN_N: f64 = 0.3;
/// Force that holds the key, N.
const HELD_N: f64 = 12.0;
/// Forces of the energy budget, N.
const HOLDS_N: [f64; 4] = [5.0, 12.0, 25.0, 40.0];
/// Weights of the bench test, kg, and their place in the key's frame, m: above the balance pin, on top of the key.
const LEADS_KG: [f64; 4] = [0.0, 0.05, 0.1, 0.2];
const ABOVE_THE_PIN_M: Vec2 = [0.0, 0.03];
/// Step of all runs but those of a whole press, s; instants of release and end.
const STEP_S: f64 = 25e-6;
const HELD_S: f64 = 0.4;
const GONE_S: f64 = 2e-3;
const END_S: f64 = 0.5;
/// Way of the key's front from the held position over which its energy is looked at, m.
const FIRST_M: f64 = 1e-3;
/// Travel of the key's back, at the front, at which it has landed, m, and place of the sensor there, m.
const LANDED_M: f64 = 0.5e-3;
const SENSOR_M: f64 = 0.235;
/// Step of a whole press, s, and time after key bottom in which the blow lifts the key, s.
const PRESS_STEP_S: f64 = 50e-6;
const BLOW_S: f64 = 0.02;

fn missing(what: &str) -> ReproduceError {
    ReproduceError::Instrument(format!("the instrument has no {what}"))
}

/// The key's piece on the balance pin.
fn back_of(instrument: &Instrument) -> Result<usize, ReproduceError> {
    Ok(instrument.first_piece(instrument.roles.key.ok_or_else(|| missing("key"))?)?)
}

fn zone_of(instrument: &Instrument, name: &str) -> Result<usize, ReproduceError> {
    let found = instrument.zones.iter().position(|zone| zone.name == name);
    found.ok_or_else(|| missing(&format!("zone `{name}`")))
}

/// Arm of the key's pin; `None` if the key is nailed.
fn pin_of(instrument: &Instrument) -> Result<Option<usize>, ReproduceError> {
    let back = back_of(instrument)?;
    Ok(instrument.lying().find(|(_, body)| *body == back).map(|(arm, _)| arm))
}

/// One action, carried in two ways.
pub(super) struct Keys {
    pub nailed: Instrument,
    pub lying: Instrument,
}

impl Keys {
    pub(super) fn of(instrument: &Instrument) -> Result<Self, ReproduceError> {
        let heel = zone_of(instrument, HEEL)?;
        if pin_of(instrument)?.is_none() {
            return Ok(Keys { nailed: instrument.clone(), lying: laid(instrument)? });
        }
        let mut nailed = instrument.clone();
        nailed.edit(|fields| fields.zones[heel].felt.stiffness /= HEEL_ALONE)?;
        Ok(Keys { nailed: nailed.nailed(back_of(instrument)?)?, lying: instrument.clone() })
    }
}

/// The nailed instrument with its key on a punching.
fn laid(nailed: &Instrument) -> Result<Instrument, ReproduceError> {
    let (back, heel) = (back_of(nailed)?, zone_of(nailed, HEEL)?);
    let mut other = nailed.clone();
    other.edit(|fields| {
        fields.zones[heel].felt.stiffness *= HEEL_ALONE;
        fields.zones.push(Zone {
            name: RAIL.into(),
            label: "key - balance-rail punching".into(),
            disc_body: Some(back),
            disc_center_m: [0.0; 2],
            disc_radius_m: 0.0,
            curve_body: None,
            curve: Curve::Line { point_m: fields.bodies[back].pivot_m, normal: [0.0, 1.0] },
            felt: Felt { stiffness: PUNCHING_N_PER_M2, exponent: 2.0, loss: PUNCHING.into(), thickness_m: Some(3e-3) },
            friction_coefficient: 0.0,
            dwell: None,
        });
    })?;
    seated(other.with_bushing(back, Bushing::Pin { friction_n: PIN_N })?)
}

/// Raises the punching by what the key sinks into it, so that the key rests as drawn.
fn seated(mut lying: Instrument) -> Result<Instrument, ReproduceError> {
    let rail = zone_of(&lying, RAIL)?;
    let at_rest = at_rest(&lying)?;
    let sunk_m = -at_rest.lifts.first().ok_or_else(|| missing("key that lies"))?.lift_m[0];
    lying.edit(|fields| {
        if let Curve::Line { point_m, .. } = &mut fields.zones[rail].curve {
            point_m[1] += sunk_m;
        }
    })?;
    Ok(lying)
}

fn at_rest(instrument: &Instrument) -> Result<Run, ReproduceError> {
    let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(10.0 * STEP_S) };
    Ok(simulate(instrument, &player::force(|_| 0.0), &setup, &mut |_| true)?)
}

/// Change of a key that lies. Factors are 1, and the rest `None`, where nothing changes.
#[derive(Clone, Copy)]
struct Change {
    /// Factors of the heel's stiffness, of the punching's, and of the punching's loss.
    heel: f64,
    punching: f64,
    loss: f64,
    /// Friction along the pins, N.
    pin_n: Option<f64>,
    /// Factor of the mass of the pin, and length of its arm, m: devices of the model.
    pin: f64,
    arm_m: Option<f64>,
}

const NONE: Change = Change { heel: 1.0, punching: 1.0, loss: 1.0, pin_n: None, pin: 1.0, arm_m: None };

impl Change {
    fn of(self, lying: &Instrument) -> Result<Instrument, ReproduceError> {
        let (heel, rail) = (zone_of(lying, HEEL)?, zone_of(lying, RAIL)?);
        let (arm, back) = (pin_of(lying)?.ok_or_else(|| missing("key that lies"))?, back_of(lying)?);
        let mut other = lying.clone();
        other.edit(|fields| {
            fields.zones[heel].felt.stiffness *= self.heel;
            fields.zones[rail].felt.stiffness *= self.punching;
            fields.zones[rail].felt.scale_loss(self.loss);
            let (pin, was_m) = (&mut fields.bodies[arm], lying.bodies[arm].center_of_mass_m[0]);
            let length_m = self.arm_m.unwrap_or(was_m);
            let friction_n = self.pin_n.unwrap_or(pin.friction_torque_n_m / was_m);
            pin.pivot_m[0] += was_m - length_m;
            pin.center_of_mass_m = [length_m, 0.0];
            pin.mass_kg *= self.pin;
            pin.inertia_kg_m2 = pin.mass_kg * length_m * length_m;
            pin.friction_torque_n_m = friction_n * length_m;
            pin.turn_rad = pin.turn_rad.map(|range| range.map(|rad| rad * was_m / length_m));
            fields.bodies[back].pivot_m = [length_m, 0.0];
        })?;
        if self.punching == 1.0 && self.loss == 1.0 { Ok(other) } else { seated(other) }
    }
}

/// With lead on the key, at a place in the frame of its piece on the balance pin, m.
fn laden(instrument: &Instrument, lead_kg: f64, [x, y]: Vec2) -> Result<Instrument, ReproduceError> {
    let back = back_of(instrument)?;
    let mut other = instrument.clone();
    other.edit(|fields| {
        let body = &mut fields.bodies[back];
        let whole_kg = body.mass_kg + lead_kg;
        let [own_x, own_y] = body.center_of_mass_m.map(|own_m| body.mass_kg * own_m);
        body.center_of_mass_m = [(own_x + lead_kg * x) / whole_kg, (own_y + lead_kg * y) / whole_kg];
        body.inertia_kg_m2 += lead_kg * (x * x + y * y);
        body.mass_kg = whole_kg;
    })?;
    Ok(other)
}

/// The key alone: no other part is there, and nothing stands on the capstan.
fn without_stack(instrument: &Instrument) -> Result<Instrument, ReproduceError> {
    let (back, arm) = (back_of(instrument)?, pin_of(instrument)?);
    let mut becomes: Vec<Option<usize>> = Vec::new();
    let mut kept = 0;
    for body in 0..instrument.bodies.len() {
        let stays = Some(body) == arm || instrument.is_same_part(body, back)?;
        becomes.push(stays.then_some(kept));
        kept += usize::from(stays);
    }
    let on = |body: Option<usize>| body.and_then(|body| becomes[body]);
    let stays = |body: Option<usize>| body.is_none_or(|body| becomes[body].is_some());
    let mut zones = Vec::new();
    let places: Vec<Option<usize>> = instrument
        .zones
        .iter()
        .map(|zone| {
            let both = stays(zone.disc_body) && stays(zone.curve_body);
            both.then(|| {
                zones.push(Zone { disc_body: on(zone.disc_body), curve_body: on(zone.curve_body), ..zone.clone() });
                zones.len() - 1
            })
        })
        .collect();
    let mut other = instrument.clone();
    other.edit(|fields| {
        let alone = becomes.iter().zip(&instrument.bodies).filter(|(index, _)| index.is_some());
        fields.bodies = alone.map(|(_, body)| body.clone()).collect();
        fields.bodies.iter_mut().for_each(|body| body.parent = on(body.parent));
        fields.springs.retain_mut(|spring| {
            let body = becomes[spring.body];
            spring.body = body.unwrap_or(spring.body);
            body.is_some()
        });
        fields.zones = zones;
        let roles = &mut fields.roles;
        roles.key = on(roles.key);
        roles.key_bottom = roles.key_bottom.and_then(|zone| places[zone]);
        roles.stops = roles.stops.iter().filter_map(|zone| places[*zone]).collect();
        (roles.hammer, roles.string, roles.pedal, roles.let_off, roles.check) = (None, None, None, None, None);
        (roles.knuckle, roles.transmits) = (Vec::new(), Vec::new());
        (fields.screws, fields.parts) = (Vec::new(), Vec::new());
        (fields.strings, fields.bridge_modes) = (Vec::new(), Vec::new());
    })?;
    Ok(other)
}

/// The key alone, with lead on the capstan that weighs what the stack presses on it with at rest.
fn lead_for_stack(instrument: &Instrument) -> Result<Instrument, ReproduceError> {
    let heel = zone_of(instrument, HEEL)?;
    let pressed_n = at_rest(instrument)?.zones[heel].normal_n[0];
    let lead_kg = pressed_n / instrument.gravity_m_per_s2;
    laden(&without_stack(instrument)?, lead_kg, instrument.zones[heel].disc_center_m)
}

/// The key alone, turned by what the stack presses on it with at rest, as if the stack had no inertia. Of a nailed key:
/// the reaction goes to the ground.
fn weight_of_stack(nailed: &Instrument) -> Result<Instrument, ReproduceError> {
    let heel = zone_of(nailed, HEEL)?;
    let torque_n_m = -at_rest(nailed)?.zones[heel].normal_n[0] * nailed.zones[heel].disc_center_m[0];
    let mut alone = without_stack(nailed)?;
    let body = back_of(&alone)?;
    alone.edit(|fields| {
        fields.springs.push(Spring { name: "stack".into(), body, torque_n_m, stiffness_n_m_per_rad: 0.0 });
    })?;
    Ok(alone)
}

/// Without dry friction in any pivot, or along the pin. What is left of a bend's is the device that stills it.
fn frictionless(instrument: &Instrument) -> Result<Instrument, ReproduceError> {
    let arm = pin_of(instrument)?;
    let mut other = instrument.clone();
    other.edit(|fields| {
        for (index, body) in fields.bodies.iter_mut().enumerate() {
            if !body.is_bend || Some(index) == arm {
                // Not quite none, so that all comes to rest.
                body.friction_torque_n_m *= 1e-6;
            }
        }
    })?;
    Ok(other)
}

/// With a front punching that gives back all that it takes.
fn bouncing(instrument: &Instrument) -> Result<Instrument, ReproduceError> {
    let bottom = instrument.roles.key_bottom.ok_or_else(|| missing("front punching (`roles.key_bottom`)"))?;
    let mut other = instrument.clone();
    other.edit(|fields| fields.zones[bottom].felt.scale_loss(0.0))?;
    Ok(other)
}

fn mm(length_m: f64) -> String {
    format!("{:.2}", 1e3 * length_m)
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}

/// Humps as `0.35 at 9.1`.
fn told(humps: &[Hump]) -> String {
    let told: Vec<String> = humps.iter().map(|h| format!("{} at {:.1}", mm(h.height_m), 1e3 * h.top_s)).collect();
    if told.is_empty() { "none".into() } else { told.join(", ") }
}

fn released(instrument: &Instrument, held_n: f64) -> Result<Release, ReproduceError> {
    let_go(instrument, held_n, &mut |_| true).map_err(|error| ReproduceError::Instrument(error.to_string()))
}

/// A run in which the key is pressed slowly, held, and let go.
fn held_and_let_go(instrument: &Instrument, held_n: f64) -> Result<Run, ReproduceError> {
    // Slowly, so that the punching takes what statics says and the hammer is caught or falls as it may.
    let force = |t: f64| held_n * (t / 0.2).min(1.0) * (1.0 - (t - HELD_S) / GONE_S).clamp(0.0, 1.0);
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(END_S) };
    Ok(simulate(instrument, &player::force(force), &setup, &mut |_| true)?)
}

/// Times after the key has landed in which nothing presses on its capstan, s: beginnings and ends.
fn stack_apart(instrument: &Instrument) -> Result<Vec<[f64; 2]>, ReproduceError> {
    let run = held_and_let_go(instrument, HELD_N)?;
    let (back, heel) = (back_of(instrument)?, zone_of(instrument, HEEL)?);
    let lever = -instrument.roles.key_front_m[0] / SENSOR_M;
    let lift_m = |row: usize| run.lifts.first().map_or(0.0, |lift| lift.lift_m[row]);
    // The back rises as the front falls.
    let back_m = |row: usize| lever * (SENSOR_M * run.bodies[back].angle_rad[row].sin() + lift_m(row));
    let go = run.time_s.partition_point(|&t| t < HELD_S);
    let rows = go..run.time_s.len();
    let landed = rows.clone().find(|&row| back_m(row) - back_m(0) < LANDED_M);
    let landed = landed.ok_or_else(|| ReproduceError::Instrument("the key does not come home".into()))?;
    let mut apart: Vec<[f64; 2]> = Vec::new();
    for row in landed..rows.end {
        let since_s = run.time_s[row] - run.time_s[landed];
        let touches = run.zones[heel].normal_n[row] > 0.0;
        match apart.last_mut() {
            Some(last) if last[1].is_nan() && touches => last[1] = since_s,
            Some(last) if last[1].is_nan() => {}
            _ if !touches => apart.push([since_s, f64::NAN]),
            _ => {}
        }
    }
    Ok(apart)
}

/// Energies of a key that is let go, J, and its speed, m/s, when its front has risen by [`FIRST_M`], or is highest if
/// it does not rise so far.
struct Budget {
    /// Taken by the front punching as the key went down, and given back.
    taken_j: f64,
    given_j: f64,
    /// Taken by the finger while its force vanished.
    finger_j: f64,
    /// Kinetic energy of the key about its pivot.
    key_j: f64,
    speed_m_per_s: f64,
}

fn budget(instrument: &Instrument, held_n: f64) -> Result<Budget, ReproduceError> {
    let run = held_and_let_go(instrument, held_n)?;
    let held = run.time_s.partition_point(|&t| t < HELD_S);
    let risen = run.key_m[held..].iter().position(|y| *y < run.key_m[held] - FIRST_M);
    let highest = || {
        let rows = run.key_m[held..].iter().enumerate();
        rows.min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(row, _)| row)
    };
    let until = held + risen.unwrap_or_else(highest);
    let bottom = instrument.roles.key_bottom.unwrap_or(0);
    let work = |force: &[f64], from: usize, to: usize| {
        (from..to).map(|row| 0.5 * (force[row] + force[row + 1]) * (run.key_m[row + 1] - run.key_m[row])).sum::<f64>()
    };
    let punching = &run.zones[bottom].normal_n;
    let arm_m = instrument.roles.key_front_m[0];
    let key = instrument.roles.key.unwrap_or(0);
    let turn = run.bodies[key].rate_rad_per_s[until];
    let pieces = (0..instrument.bodies.len()).filter(|&body| instrument.is_same_part(body, key).unwrap_or(false));
    let inertia: f64 = pieces.map(|body| instrument.bodies[body].inertia_kg_m2).sum();
    Ok(Budget {
        taken_j: work(punching, 0, held),
        given_j: -work(punching, held, until),
        finger_j: -work(&run.force_n, held, until),
        key_j: 0.5 * inertia * turn * turn,
        speed_m_per_s: (arm_m * turn).abs(),
    })
}

/// A whole press at ff: instants, s, and lifts, m, of a key that lies.
struct Press {
    speed_m_per_s: Option<f64>,
    impact_s: Option<f64>,
    bottom_s: Option<f64>,
    /// Largest lift before key bottom, just after it, and from the check on; the lift as the key is let go; and the
    /// largest afterwards.
    lifts_m: Option<[f64; 5]>,
    /// Whether the blow takes the key off the rail.
    is_off: bool,
}

impl Press {
    fn of(instrument: &Instrument, touch: Touch) -> Result<Self, ReproduceError> {
        let wrong = |error: erard::level::LevelError| ReproduceError::Instrument(error.to_string());
        let ff = named("ff").ok_or_else(|| missing("level ff"))?;
        let mut reference = Reference::new(instrument, &mut |_| true).map_err(wrong)?;
        let solved = reference.solve(HandKind::new(touch, MASS_KG), ff, &mut |_| true).map_err(wrong)?;
        let setup = Setup { settings: Settings::new(PRESS_STEP_S), record_every: Some(1), ..Setup::new(DURATION_S) };
        let run = press_by_hand(instrument, &solved.whole(), &setup, &mut |_| true)?;
        let events = &run.events;
        let start_s = events.key_start_s.unwrap_or(0.0);
        let bottom_s = events.key_bottom_s.unwrap_or(LET_GO_S);
        let check_s = events.check_s.unwrap_or(LET_GO_S);
        let rows = |from_s: f64, to_s: f64| {
            let row = |s: f64| run.time_s.partition_point(|&t| t < s);
            row(from_s)..row(to_s)
        };
        let most = |lift_m: &[f64], from_s: f64, to_s: f64| {
            lift_m[rows(from_s, to_s)].iter().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        let lifts_m = run.lifts.first().map(|lift| {
            let most = |from_s: f64, to_s: f64| most(&lift.lift_m, from_s, to_s);
            [
                most(0.0, bottom_s),
                most(bottom_s, bottom_s + BLOW_S),
                most(check_s, LET_GO_S),
                most(LET_GO_S - 1.5 * PRESS_STEP_S, LET_GO_S),
                most(LET_GO_S, DURATION_S),
            ]
        });
        let rail = run.zones.iter().find(|zone| zone.name == RAIL);
        let is_off = |normal_n: &[f64]| normal_n[rows(bottom_s, bottom_s + BLOW_S)].contains(&0.0);
        Ok(Press {
            speed_m_per_s: events.hammer_speed_m_per_s(),
            impact_s: events.hammer_contact_s().map(|s| s - start_s),
            bottom_s: events.key_bottom_s.map(|s| s - start_s),
            lifts_m,
            is_off: rail.is_some_and(|zone| is_off(&zone.normal_n)),
        })
    }

    fn cells(&self) -> Vec<String> {
        let ms = |s: Option<f64>| or_dash(s.map(|s| 1e3 * s), 2);
        let after = self.bottom_s.zip(self.impact_s).map(|(bottom, impact)| bottom - impact);
        let lift = |n: usize| {
            let lift_m = self.lifts_m.map(|all| all[n]).filter(|m| m.is_finite());
            or_dash(lift_m.map(|m| 1e3 * m), 2)
        };
        [or_dash(self.speed_m_per_s, 2), ms(self.impact_s), ms(after)].into_iter().chain((0..5).map(lift)).collect()
    }
}

/// Progress, counted in simulations.
struct Going<'a, 'p> {
    done: f64,
    of: f64,
    progress: &'a mut Progress<'p>,
}

impl Going<'_, '_> {
    fn next(&mut self) -> Result<(), ReproduceError> {
        self.done += 1.0;
        tell(self.progress, self.done / self.of)
    }
}

/// Releases, each with its name: how the key is carried, and what else could make two humps.
fn releases(keys: &Keys, going: &mut Going<'_, '_>) -> Result<(Table, Vec<Release>), ReproduceError> {
    let mut table = Table::new(
        format!(
            "The key is held with {HELD_N} N and let go within 2 ms; travel of its back as at the front, from its landing"
        ),
        &["key", "humps (mm at ms)", "home (ms)", "9 to 4 mm (m/s)", "largest lift (mm)", "hammer held at (mm)"],
    );
    let lying = |change: Change| change.of(&keys.lying);
    let arm_m = pin_of(&keys.lying)?.map(|arm| keys.lying.bodies[arm].center_of_mass_m[0]).unwrap_or_default();
    let cases: [(&str, Instrument); 15] = [
        ("nailed to its pin, heel and punching in series", keys.nailed.clone()),
        ("lying on its punching", keys.lying.clone()),
        ("arm of 3 m, pin of half the mass", lying(Change { arm_m: Some(3.0), pin: 0.5, ..NONE })?),
        ("arm of half the length", lying(Change { arm_m: Some(0.5 * arm_m), ..NONE })?),
        ("heel as where the key is nailed", lying(Change { heel: 1.0 / HEEL_ALONE, ..NONE })?),
        ("no friction on the pins", lying(Change { pin_n: Some(0.0), ..NONE })?),
        ("friction 0.1 N", lying(Change { pin_n: Some(0.1), ..NONE })?),
        ("friction 1 N", lying(Change { pin_n: Some(1.0), ..NONE })?),
        ("punching of half the stiffness, as on a rail that yields", lying(Change { punching: 0.5, ..NONE })?),
        ("punching of twice the stiffness", lying(Change { punching: 2.0, ..NONE })?),
        ("punching without loss", lying(Change { loss: 0.0, ..NONE })?),
        ("no stack, lead on the capstan: nailed", lead_for_stack(&keys.nailed)?),
        ("no stack, lead on the capstan: lying", lead_for_stack(&keys.lying)?),
        ("no dry friction anywhere: nailed", frictionless(&keys.nailed)?),
        ("no dry friction anywhere: lying", frictionless(&keys.lying)?),
    ];
    let mut found = Vec::new();
    for (name, instrument) in cases {
        going.next()?;
        let release = released(&instrument, HELD_N)?;
        table.row([
            name.into(),
            release.humps.as_deref().map_or_else(|| "does not come home".into(), told),
            or_dash(release.home_s.map(|s| 1e3 * s), 1),
            or_dash(release.speed_m_per_s, 3),
            or_dash(release.lift_m.map(|m| 1e3 * m), 2),
            or_dash(instrument.roles.hammer.map(|_| 1e3 * release.held_hammer_m), 1),
        ]);
        found.push(release);
    }
    Ok((table, found))
}

/// When the stack leaves the capstan after the key has landed, and falls back onto it.
fn capstan(keys: &Keys, going: &mut Going<'_, '_>) -> Result<(Table, Vec<[f64; 2]>), ReproduceError> {
    let mut table = Table::new(
        "The stack leaves the capstan of a key let go and falls back onto it (ms after the key's landing)",
        &["key", "apart"],
    );
    let mut nailed = Vec::new();
    for (name, instrument) in [("nailed", &keys.nailed), ("lying", &keys.lying)] {
        going.next()?;
        let apart = stack_apart(instrument)?;
        let shown: Vec<String> = apart
            .iter()
            .map(|[from, to]| {
                let until = if to.is_nan() { String::new() } else { format!(" to {:.1}", 1e3 * to) };
                format!("{:.1}{until}", 1e3 * from)
            })
            .collect();
        table.row([name.into(), if shown.is_empty() { "never".into() } else { shown.join(", ") }]);
        if name == "nailed" {
            nailed = apart;
        }
    }
    Ok((table, nailed))
}

/// The bench test: returns of the nailed and of the lying key over the lead above its pin, m.
fn bench(keys: &Keys, going: &mut Going<'_, '_>) -> Result<(Table, Vec<[f64; 2]>), ReproduceError> {
    let mut table = Table::new(
        "A test for a bench: lead exactly above the balance pin, largest return of a key that slips (mm). The nailed \
         key's does not change, the lying key's grows",
        &["lead (g)", "nailed", "lying"],
    );
    let mut returns = Vec::new();
    for lead_kg in LEADS_KG {
        going.next()?;
        let of = |instrument: &Instrument| -> Result<f64, ReproduceError> {
            Ok(released(&laden(instrument, lead_kg, ABOVE_THE_PIN_M)?, HELD_N)?.rebound_m.unwrap_or(0.0))
        };
        let pair = [of(&keys.nailed)?, of(&keys.lying)?];
        table.row([format!("{:.0}", 1e3 * lead_kg), mm(pair[0]), mm(pair[1])]);
        returns.push(pair);
    }
    Ok((table, returns))
}

/// The lift over a whole press at ff, and whether the blow at key bottom takes the key off its rail in every touch.
fn presses(keys: &Keys, going: &mut Going<'_, '_>) -> Result<(Table, Vec<bool>), ReproduceError> {
    let mut table = Table::new(
        format!(
            "A whole press at ff, let go after {LET_GO_S} s: instants, and the largest lift of the key's pivot from \
             the drawn place (mm): before key bottom, within {:.0} ms of it, and from the check on; the lift of the key that \
             is held, as it is let go; and the largest after that",
            1e3 * BLOW_S
        ),
        &[
            "touch, key",
            "hammer (m/s)",
            "impact (ms)",
            "bottom after it (ms)",
            "before",
            "blow",
            "checked",
            "held",
            "let go",
        ],
    );
    let mut off = Vec::new();
    for (touch, name) in [(Touch::Pressed, "pressed"), (Touch::Struck, "struck")] {
        for (key, instrument) in [("nailed", &keys.nailed), ("lying", &keys.lying)] {
            going.next()?;
            let press = Press::of(instrument, touch)?;
            table.row([format!("{name}, {key}")].into_iter().chain(press.cells()));
            if key == "lying" {
                off.push(press.is_off);
            }
        }
    }
    Ok((table, off))
}

/// The energy of the first millimetre, and the speed of the lying key that is fastest, m/s.
fn energies(keys: &Keys, going: &mut Going<'_, '_>) -> Result<(Table, f64), ReproduceError> {
    let mut table = Table::new(
        format!("Energies when the front of the key has risen by {} mm (mJ)", 1e3 * FIRST_M),
        &["key", "held (N)", "punching took", "gave back", "finger took", "key turns with", "front (m/s)"],
    );
    let mut cases: Vec<(&str, Instrument, f64)> =
        HOLDS_N.iter().map(|held_n| ("lying", keys.lying.clone(), *held_n)).collect();
    let elastic = bouncing(&keys.lying)?;
    cases.extend([
        ("nailed", keys.nailed.clone(), HELD_N),
        ("lying, no dry friction", frictionless(&keys.lying)?, HELD_N),
        ("lying, front punching without loss", elastic.clone(), HELD_N),
        ("the same", elastic, HOLDS_N[3]),
        ("lying, lead for the stack", lead_for_stack(&keys.lying)?, HELD_N),
        ("lying, nothing for the stack", without_stack(&keys.lying)?, HELD_N),
        ("nailed, the stack's weight without its mass", weight_of_stack(&keys.nailed)?, HELD_N),
    ]);
    let mut fastest = 0.0_f64;
    for (n, (name, instrument, held_n)) in cases.iter().enumerate() {
        going.next()?;
        let of = budget(instrument, *held_n)?;
        let mj = |energy_j: f64| format!("{:.2}", 1e3 * energy_j);
        if n < HOLDS_N.len() {
            fastest = fastest.max(of.speed_m_per_s);
        }
        table.row([
            (*name).to_owned(),
            format!("{held_n}"),
            mj(of.taken_j),
            mj(of.given_j),
            mj(of.finger_j),
            mj(of.key_j),
            format!("{:.3}", of.speed_m_per_s),
        ]);
    }
    Ok((table, fastest))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    tell(progress, 0.0)?;
    let keys = Keys::of(instrument)?;
    let mut going = Going { done: 0.0, of: 15.0 + 2.0 + 4.0 + 4.0 + 11.0, progress };
    let (releases, found) = releases(&keys, &mut going)?;
    let (capstan, apart) = capstan(&keys, &mut going)?;
    let (bench, returns) = bench(&keys, &mut going)?;
    let (presses, off) = presses(&keys, &mut going)?;
    let (energies, fastest) = energies(&keys, &mut going)?;
    let height = |release: &Release| release.rebound_m.unwrap_or(0.0);
    let count = |release: &Release| release.humps.as_ref().map_or(0, Vec::len);
    let [nailed, lying, device] = [0, 1, 2].map(|n| &found[n]);
    let moved = devices_move(lying, device);
    let claims = vec![
        Claim::new(
            "this program",
            "a key that lies on its rail comes back by less than one that is nailed to its pin",
            format!("{} mm for {} mm", mm(height(lying)), mm(height(nailed))),
            height(lying) < height(nailed),
        ),
        Claim::new(
            "this program",
            "lead above the balance pin makes a lying key come back further, and changes a nailed one by less than 0.1 mm",
            format!(
                "{} to {} mm; nailed {} to {}",
                mm(returns[0][1]),
                mm(returns[3][1]),
                mm(returns[0][0]),
                mm(returns[3][0])
            ),
            returns[3][1] > returns[0][1] && (returns[3][0] - returns[0][0]).abs() < 0.1e-3,
        ),
        Claim::new(
            "this program",
            "an arm of 3 m with a pin of half the mass changes return, humps and lift by less than 1 %",
            format!("by {:.2} %", 100.0 * moved),
            moved < 0.01,
        ),
        Claim::new(
            "this program",
            "a nailed key comes back once, whether or not its stack falls back onto the capstan",
            format!(
                "{} hump(s); the stack comes back {} time(s)",
                count(nailed),
                apart.iter().filter(|[_, to]| !to.is_nan()).count()
            ),
            count(nailed) == 1,
        ),
        Claim::new(
            "R. Masoudi, S. Birkett, J. McPhee (2014, 2015), read in their abstracts",
            "a key lifts off its balance punching; here, from the blow at key bottom at ff, pressed and struck",
            format!("pressed {}, struck {}", off[0], off[1]),
            off.iter().all(|off| *off),
        ),
        Claim::new(
            "recordings (Kawai KG-3C)",
            "a key let go comes back twice",
            format!("{} hump(s) of the lying key", count(lying)),
            count(lying) == 2,
        ),
        Claim::new(
            "recordings (Kawai KG-3C)",
            "a key let go rises with 0.35 m/s within its first millimetre",
            format!("{fastest:.3} m/s at the most of {} to {} N", HOLDS_N[0], HOLDS_N[3]),
            fastest >= 0.35,
        ),
    ];
    Ok(Section {
        text: vec![
            "A key is free upward: nothing but its weight, and what stands on it, holds it on the punching of the balance \
             rail. When its back meets the cloth, 268 mm behind its centre of mass, it turns about that cloth, and its \
             balance hole rises. A nailed key has the heel of heel and punching in series; where the key lies, the heel \
             has its own stiffness."
                .to_owned(),
            "Rival causes of two humps: a rail that yields under all keys, for which a punching of half the stiffness \
             stands (a rail's own mass is left out); the stack that falls back onto the capstan; and, as a test of that, \
             a key without its stack, with lead on the capstan of the weight that the stack has there at rest."
                .to_owned(),
        ],
        claims,
        tables: vec![releases, capstan, bench, presses, energies],
        ..Section::default()
    })
}

/// Largest relative change of return, humps and lift between two releases; 1 if the humps differ in number.
fn devices_move(usual: &Release, other: &Release) -> f64 {
    let of = |release: &Release| -> Vec<f64> {
        let humps = release.humps.iter().flatten().flat_map(|hump| [hump.height_m, hump.top_s]);
        [release.rebound_m, release.lift_m].into_iter().flatten().chain(humps).collect()
    };
    let (usual, other) = (of(usual), of(other));
    if usual.len() != other.len() {
        return 1.0;
    }
    usual.iter().zip(&other).map(|(a, b)| (b / a - 1.0).abs()).fold(0.0, f64::max)
}
