//! Pivots that move a little in one direction: on compliant cloth, or lying on a felt from which they can lift.
//!
//! Such a pivot is modelled as a pivot at the end of a long arm. The arm is a body of its own, and hinged in line with
//! the pivot on the body that carried the pivot before. So the engine needs no new kind of joint. For the rigid
//! geometry the arm is a piece of the body that carries it ([`Instrument::locked`]). What holds the arm is one of two
//! ([`Bushing`]): a spring, or a zone at the pivot, which can only push.

use super::{Body, DamperFelt, Instrument, InstrumentFields, ScrewAction, Spring};
use crate::index::IndexError;

/// Length of the arm of a bushing of cloth, m: long enough that the pivot's path is practically straight over its
/// compression.
const CLOTH_ARM_M: f64 = 0.3;
/// Length of the arm of a sliding pin, m. The dry torque between body and arm presses on the pivot with torque over
/// length: a key's 0.01 N m with 0.01 N, of the 2.5 N that its rail bears.
const PIN_ARM_M: f64 = 1.0;
/// Mass of the pin at the arm's end, kg: small compared with every part of an action.
const PIN_KG: f64 = 1e-3;
/// Dry friction of a pin on a spring, N, which brings the arm to rest.
const DRY_N: f64 = 3e-3;
/// Farthest move along a pin that the model holds for, m. An estimate: balance pins guide a key for twice that, and the
/// pivot's path bows by 0.04 mm.
const LIFT_M: f64 = 5e-3;

/// Distance from a pivot within which a zone holds it, m: half of a punching.
const AT_PIVOT_M: f64 = 10e-3;

/// What holds a pivot that can move at right angles to the x axis of the body that carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bushing {
    /// Compliant cloth around the pin: a spring and a damper in parallel, both ways.
    Cloth {
        /// Stiffness, N/m.
        n_per_m: f64,
        /// Damping, N s/m.
        n_s_per_m: f64,
    },
    /// A pin along which the pivot slides: only the instrument's zones hold it, so it can lift.
    Pin {
        /// Dry friction along the pin, N.
        friction_n: f64,
    },
}

impl Bushing {
    /// End of the names of its arm (a body) and of its spring.
    fn ending(self) -> &'static str {
        match self {
            Bushing::Cloth { .. } => "bushing",
            Bushing::Pin { .. } => "pin",
        }
    }
}

/// The device that represents a pivot that moves.
#[derive(Debug, Clone, Copy)]
struct Arm {
    length_m: f64,
    pin_kg: f64,
}

impl Instrument {
    /// Returns the name of a body's arm, and of the spring of [`Bushing::Cloth`].
    #[must_use]
    pub(crate) fn bushing_name(&self, body: usize, bushing: Bushing) -> String {
        format!("{}_{}", self.bodies[body].name, bushing.ending())
    }

    /// Returns the instrument with a bushing at a body's pivot, which can then move at right angles to the x axis of
    /// the body that carries it (up and down on the ground). The bushing adds a body, right before this one; cloth adds
    /// a spring, the last.
    ///
    /// # Errors
    /// There is no such body.
    pub fn with_bushing(&self, body: usize, bushing: Bushing) -> Result<Instrument, IndexError> {
        IndexError::check("body", body, self.bodies.len())?;
        Ok(self.with_bushing_at(body, bushing))
    }

    /// [`Instrument::with_bushing`] of a body that exists.
    pub(crate) fn with_bushing_at(&self, body: usize, bushing: Bushing) -> Instrument {
        let length_m = match bushing {
            Bushing::Cloth { .. } => CLOTH_ARM_M,
            Bushing::Pin { .. } => PIN_ARM_M,
        };
        self.with_arm(body, bushing, Arm { length_m, pin_kg: PIN_KG })
    }

    fn with_arm(&self, body: usize, bushing: Bushing, Arm { length_m, pin_kg }: Arm) -> Instrument {
        let mut other = self.fields.clone();
        let own = &self.bodies[body];
        let (name, square) = (self.bushing_name(body, bushing), length_m * length_m);
        let (friction_n, n_s_per_m) = match bushing {
            Bushing::Cloth { n_s_per_m, .. } => (DRY_N, n_s_per_m),
            Bushing::Pin { friction_n } => (friction_n, 0.0),
        };
        let arm = Body {
            name: name.clone(),
            parent: own.parent,
            pivot_m: [own.pivot_m[0] - length_m, own.pivot_m[1]],
            angle_rad: own.parent.map_or(0.0, |parent| self.bodies[parent].angle_rad),
            mass_kg: pin_kg,
            inertia_kg_m2: pin_kg * square,
            center_of_mass_m: [length_m, 0.0],
            friction_torque_n_m: friction_n * length_m,
            viscous_n_m_s: n_s_per_m * square,
            dwell: None,
            is_bend: true,
            turn_rad: match bushing {
                Bushing::Cloth { .. } => None,
                Bushing::Pin { .. } => Some([-LIFT_M / length_m, LIFT_M / length_m]),
            },
        };
        // The arm takes the body's index; the indices of the body and of all later ones grow by one.
        let moved = |index: &mut usize| *index += usize::from(*index >= body);
        other.bodies.insert(body, arm);
        other.bodies.iter_mut().skip(body + 1).filter_map(|b| b.parent.as_mut()).for_each(moved);
        (other.bodies[body + 1].parent, other.bodies[body + 1].pivot_m) = (Some(body), [length_m, 0.0]);
        other.springs.iter_mut().for_each(|spring| moved(&mut spring.body));
        for zone in &mut other.zones {
            [&mut zone.disc_body, &mut zone.curve_body].into_iter().flatten().for_each(moved);
        }
        [&mut other.roles.key, &mut other.roles.hammer].into_iter().flatten().for_each(moved);
        other.parts.iter_mut().filter_map(|part| part.body.as_mut()).for_each(moved);
        if let Bushing::Cloth { n_per_m, .. } = bushing {
            let stiffness_n_m_per_rad = n_per_m * square;
            other.springs.push(Spring { name, body, torque_n_m: 0.0, stiffness_n_m_per_rad });
        }
        Instrument { fields: other }
    }

    /// Returns the instrument with the pivot of a body that slides along a pin ([`Bushing::Pin`]) nailed to its drawn
    /// place: without the arm and without the zone on which the pivot lies. Later indices of bodies and of zones fall
    /// by one, and screws and roles of that zone go with it. A body whose pivot does not slide stays as it is.
    ///
    /// # Errors
    /// There is no such body.
    pub fn nailed(&self, body: usize) -> Result<Instrument, IndexError> {
        IndexError::check("body", body, self.bodies.len())?;
        let Some((index, _)) = self.lying().find(|(_, lying)| *lying == body) else { return Ok(self.clone()) };
        let mut other = self.fields.clone();
        if let Some(zone) = self.lies_on(body) {
            remove_zone(&mut other, zone);
        }
        // The arm precedes its body.
        let arm = other.bodies.remove(index);
        other.bodies[body - 1].pivot_m = [arm.pivot_m[0] + arm.center_of_mass_m[0], arm.pivot_m[1]];
        // What is on the arm, the body's hinge above all, comes to the body that carries the arm.
        let lowered = |old: usize| old - usize::from(old > index);
        let on = |old: Option<usize>| if old == Some(index) { arm.parent } else { old.map(lowered) };
        other.bodies.iter_mut().for_each(|one| one.parent = on(one.parent));
        other.springs.iter_mut().for_each(|spring| spring.body = lowered(spring.body));
        for zone in &mut other.zones {
            (zone.disc_body, zone.curve_body) = (on(zone.disc_body), on(zone.curve_body));
        }
        (other.roles.key, other.roles.hammer) = (on(other.roles.key), on(other.roles.hammer));
        other.parts.iter_mut().for_each(|part| part.body = on(part.body));
        Ok(Instrument { fields: other })
    }

    /// Returns the instrument with a key that lies held down as well, by a second felt like the one on which it lies,
    /// from above: for a key whose position a sensor gives. What is imposed on the front of a key that lies can lift
    /// its pivot, and a sensor's noise does. Under a load it sinks as before. A key that is nailed stays as it is.
    #[must_use]
    pub fn with_held_key(&self) -> Instrument {
        let key = self.roles.key.map(|key| self.first_piece_of(key));
        let pin = key.and_then(|key| self.lying().find(|(_, lying)| *lying == key));
        let Some((rail, (arm, key))) = key.and_then(|key| self.lies_on(key)).zip(pin) else { return self.clone() };
        let mut other = self.fields.clone();
        let mut above = other.zones[rail].clone();
        // Where the pivot is drawn, in the frame of what carries the arm.
        let drawn_m = [self.bodies[arm].pivot_m[0] + self.bodies[arm].center_of_mass_m[0], self.bodies[arm].pivot_m[1]];
        above.name = format!("{}_from_above", above.name);
        above.label = format!("{}, from above", above.label);
        (above.disc_body, above.disc_center_m, above.disc_radius_m) = (Some(key), [0.0; 2], 0.0);
        (above.curve_body, above.curve) =
            (self.bodies[arm].parent, super::Curve::Line { point_m: drawn_m, normal: [0.0, -1.0] });
        other.zones.push(above);
        Instrument { fields: other }
    }

    /// Finds the zone on which the pivot of a body lies: side A is on this body within a centimetre of the pivot, and
    /// side B is a line on the body that carries the hinge, or the arm of its pin. `None`: the pivot lies on nothing.
    #[must_use]
    pub(crate) fn lies_on(&self, body: usize) -> Option<usize> {
        let carrier = self.bodies[body].parent;
        let carrier = carrier.filter(|&arm| self.is_pin(arm)).map_or(carrier, |arm| self.bodies[arm].parent);
        self.zones.iter().position(|zone| {
            let is_line = matches!(zone.curve, super::Curve::Line { .. }) && zone.curve_body == carrier;
            is_line
                && zone.disc_body == Some(body)
                && libm::hypot(zone.disc_center_m[0], zone.disc_center_m[1]) < AT_PIVOT_M
        })
    }

    /// Iterates over the bodies whose pivots slide along a pin, each after its arm: `(arm, body)`.
    pub fn lying(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let arm_of = |(body, one): (usize, &Body)| one.parent.filter(|&arm| self.is_pin(arm)).map(|arm| (arm, body));
        self.bodies.iter().enumerate().filter_map(arm_of)
    }

    /// Rise of the pivot at the end of a pin's arm, m, when the arm has turned by this angle against the body that
    /// carries it, rad, both from the drawn place.
    #[must_use]
    pub(crate) fn lift_m(&self, arm: usize, turned_rad: f64) -> f64 {
        self.bodies[arm].center_of_mass_m[0] * libm::sin(turned_rad)
    }

    /// Whether a body is the arm of a bushing: a device, whose mass is no number of the file.
    #[must_use]
    pub fn is_arm(&self, body: usize) -> bool {
        let Body { is_bend, mass_kg, inertia_kg_m2, center_of_mass_m: [x, _], .. } = self.bodies[body];
        is_bend && (inertia_kg_m2 / (mass_kg * x * x) - 1.0).abs() < 1e-12
    }

    /// Whether a body is the arm of a pin along which a pivot slides.
    #[must_use]
    fn is_pin(&self, body: usize) -> bool {
        let arm = &self.bodies[body];
        arm.is_bend && self.springs.iter().all(|spring| spring.body != body)
    }
}

/// Removes a zone with the roles and the screws that refer to it.
fn remove_zone(fields: &mut InstrumentFields, removed: usize) {
    let after = |zone: usize| (zone != removed).then(|| zone - usize::from(zone > removed));
    fields.zones.remove(removed);
    let roles = &mut fields.roles;
    let single = [&mut roles.key_bottom, &mut roles.string, &mut roles.pedal, &mut roles.let_off, &mut roles.check];
    single.into_iter().for_each(|zone| *zone = zone.and_then(after));
    for several in [&mut roles.knuckle, &mut roles.transmits, &mut roles.stops] {
        *several = several.iter().filter_map(|zone| after(*zone)).collect();
    }
    fields.screws.retain_mut(|screw| match &mut screw.action {
        ScrewAction::Disc { zone, .. } | ScrewAction::Curve { zone, .. } | ScrewAction::Turn { zone } => {
            let kept = after(*zone);
            *zone = kept.unwrap_or(*zone);
            kept.is_some()
        }
        ScrewAction::Spring { .. } => true,
    });
    for string in &mut fields.strings {
        string.damper = string.damper.and_then(|felt| Some(DamperFelt { zone: after(felt.zone)?, ..felt }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::player;
    use crate::run::{Run, Setup, simulate};
    use moreau::Settings;

    /// A key alone, without gravity and friction: pushed at its front until it flies on toward the punching there.
    const KEY: &str = r#"
format = "erard-instrument/1"
name = "A key alone"
gravity_m_s2 = 0
[[body]]
name = "key"
pivot_mm = [0, 0]
mass_g = 140
inertia_kg_m2 = 3.737e-3
center_of_mass_mm = [-43.35, 0]
pin_friction_N = 0
[[zone]]
name = "balance_rail"
disc = { body = "key", center_mm = [0, 0] }
line = { body = "ground", point_mm = [0, 0], normal = [0, 1] }
felt = { stiffness_N_per_m_r = 1e9, exponent = 2 }
[[zone]]
name = "front"
disc = { body = "key", center_mm = [-265, 0] }
line = { body = "ground", point_mm = [-265, -9], normal = [0, 1] }
felt = { stiffness_N_per_m_r = 1e9, exponent = 2 }
[roles]
key = "key"
key_front_mm = [-265, 0]
[finger]
stiffness_N_per_m = 1e5
damping_N_s_per_m = 10
"#;

    fn thrown(instrument: &Instrument) -> Run {
        let force = |t: f64| if t < 0.02 { 2.0 } else { 0.0 };
        let setup = Setup { settings: Settings::new(10e-6), record_every: Some(1), ..Setup::new(0.1) };
        simulate(instrument, &player::force(force), &setup, &mut |_| true).unwrap()
    }

    /// A blow at the front changes the velocities of a free key as the impulse equations of a rigid bar say: dv = P/m,
    /// dw = P d/J, with the distance d of the blow from the centre of mass. No law of a felt takes part in their ratio,
    /// and so the pivot rises. A key on a rigid pivot has none of it.
    #[test]
    fn a_blow_at_the_front_lifts_the_pivot_as_of_a_free_bar() {
        let run = thrown(&Instrument::parse(KEY, "key.toml").unwrap());
        let touches = |name: &str, row: usize| run.zones.iter().any(|z| z.name == name && z.normal_n[row] > 0.0);
        let begins = (0..run.time_s.len()).find(|&row| touches("front", row)).unwrap() - 1;
        let ends = (begins + 2..run.time_s.len()).find(|&row| !touches("front", row)).unwrap();
        assert!((begins..ends).all(|row| run.force_n[row] == 0.0), "the finger has left");
        let rate = |name: &str, row: usize| {
            run.bodies.iter().find(|body| body.name == name).map(|body| body.rate_rad_per_s[row]).unwrap()
        };
        let [rise, turn] = ["key_pin", "key"].map(|name| rate(name, ends) - rate(name, begins));
        let (mass, center_m, front_m) = (0.140, -0.04335, -0.265);
        let inertia = 3.737e-3 - mass * center_m * center_m;
        let expected = inertia / (mass * (front_m - center_m)) - center_m;
        let found = PIN_ARM_M * rise / turn;
        println!("pivot {} m/s, turn {turn} rad/s: {found} m, a free bar {expected} m", PIN_ARM_M * rise);
        // The pin of 1 g at the arm's end is the difference.
        assert!((found / expected - 1.0).abs() < 0.02);
        let most = run.lifts[0].lift_m.iter().copied().fold(0.0, f64::max);
        assert!(
            run.lifts[0].name == "key" && most > 1e-4 && run.columns().iter().any(|(name, _)| name == "key_lift_m")
        );
    }

    /// The arm is a device: one three times as long, and a pin of half the mass, change the lift and the bounce by less
    /// than a hundredth.
    #[test]
    fn neither_the_arm_nor_the_mass_of_the_pin_counts() {
        let text = KEY.replace("pin_friction_N = 0", "");
        let nailed = Instrument::parse(&text, "key.toml").unwrap();
        let of = |length_m: f64, pin_kg: f64| {
            let run = thrown(&nailed.with_arm(0, Bushing::Pin { friction_n: 0.05 }, Arm { length_m, pin_kg }));
            let most = |series: &[f64]| series.iter().copied().fold(0.0, f64::max);
            let turn = run.bodies[1].rate_rad_per_s.iter().map(|rate| -rate).collect::<Vec<_>>();
            [most(&run.lifts[0].lift_m), most(&turn)]
        };
        let [usual, long, light] = [of(PIN_ARM_M, PIN_KG), of(3.0, PIN_KG), of(PIN_ARM_M, 0.5 * PIN_KG)];
        println!("lift, m, and turn, rad/s: {usual:?}, arm of 3 m {long:?}, pin of 0.5 g {light:?}");
        for other in [long, light] {
            assert!(usual.iter().zip(other).all(|(a, b)| (a / b - 1.0).abs() < 0.01));
        }
    }

    /// Nailed, an instrument whose key lies is the one whose file has neither the zone nor the pin: indices of zones in
    /// roles and screws included.
    #[test]
    fn nailed_it_is_the_file_without_zone_and_pin() {
        let screw = |name: &str, zone: &str| {
            format!(
                "[[screw]]\nname = \"{name}\"\nzone = \"{zone}\"\nside = \"curve\"\ndirection = [0, 1]\nsetting_mm = 0.1\n"
            )
        };
        let regulated = KEY.replace("key_front_mm", "key_bottom = \"front\"\nkey_front_mm") + &screw("dip", "front");
        let lying = regulated.clone() + &screw("height", "balance_rail");
        let (from, to) = (regulated.find("[[zone]]").unwrap(), regulated.rfind("[[zone]]").unwrap());
        let without = (regulated[..from].to_owned() + &regulated[to..]).replace("pin_friction_N = 0", "");
        let [lying, without] = [lying, without].map(|text| Instrument::parse(&text, "key.toml").unwrap());
        assert_eq!((lying.roles.key, lying.roles.key_bottom, lying.screws.len()), (Some(1), Some(1), 2));
        assert_eq!(lying.nailed(1).unwrap(), without);
        // Held, it has the felt from above besides, and its key can go nowhere.
        let held = lying.with_held_key();
        assert_eq!((held.zones.len(), &held.zones[..2], &held.bodies), (3, &lying.zones[..], &lying.bodies));
        let most = |of: &Instrument| thrown(of).lifts[0].lift_m.iter().copied().fold(0.0, f64::max);
        assert!(most(&held) < 0.2 * most(&lying), "{} {}", most(&held), most(&lying));
        assert_eq!(without.with_held_key(), without);
        // What does not slide stays: the arm itself, and a key that is nailed.
        assert_eq!(lying.nailed(0).unwrap(), lying);
        assert_eq!(without.nailed(0).unwrap(), without);
        assert!(lying.nailed(2).is_err());
    }
}
