//! Identity of an instrument: the numbers that affect a step, by their paths, and a digest of them.
//!
//! **Paths** are the instrument file's keys with names in place of indices and with SI units: `body.hammer.mass_kg`,
//! `zone.capstan_heel.felt.stiffness_N_per_m_r`, `zone.string.disc.center_m.x`. A reference to a body or a zone is a
//! path that ends in its name, with the value 1: `zone.string.disc.body.hammer`. Paths are part of saved states: a
//! field of a Rust type may be renamed, a path may not.
//!
//! **Values** are the instrument's own: screws are turned, grading is done, bushings are bodies and springs. A value of
//! zero is left out, so that an absent key equals its default. A new key must have a value that is zero where the key
//! is absent.
//!
//! **Not listed** are entries that do not affect a step: names for people, notes and sources, drawn parts, screws,
//! which hinges count as bends, limits beyond which a run is not trusted, roles that only name events. The order in the
//! file does not count.
//!
//! **The digest** is [`fnv1a`] over the pairs, sorted by path: the path's bytes, a zero, the value's 64 bits from the
//! lowest byte on.

use crate::instrument::{
    Body, BridgeMode, Curve, DamperFelt, Dwell, Felt, Finger, Instrument, InstrumentFields, PianoString, Roles, Spring,
    Vec2, Zone,
};
use crate::saved::{FNV1A, fnv1a};

/// Most bodies and zones of a state: the engine's capacity.
pub(crate) const BODIES: usize = 12;
/// See [`BODIES`].
pub(crate) const ZONES: usize = 32;

/// The part of an instrument's identity that saved states need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Identity {
    pub digest: u64,
    /// The bodies and zones in the order of their names: a saved state's, whatever that in the file.
    pub bodies: [usize; BODIES],
    /// See `bodies`.
    pub zones: [usize; ZONES],
}

impl Identity {
    pub(crate) fn of(instrument: &Instrument) -> Self {
        let bodies = by_name(instrument.bodies.iter().map(|body| body.name.as_str()));
        let zones = by_name(instrument.zones.iter().map(|zone| zone.name.as_str()));
        Identity { digest: instrument.digest(), bodies, zones }
    }
}

/// Indices in the order of their names; places beyond stay where they are. Does not allocate.
pub(crate) fn by_name<'a, const K: usize>(names: impl Iterator<Item = &'a str>) -> [usize; K] {
    let (mut sorted, mut count) = ([(None, 0); K], 0);
    for (index, (place, name)) in sorted.iter_mut().zip(names).enumerate() {
        (*place, count) = ((Some(name), index), index + 1);
    }
    if let Some(used) = sorted.get_mut(..count) {
        used.sort_unstable();
    }
    (count..K).zip(sorted.iter_mut().skip(count)).for_each(|(index, place)| place.1 = index);
    sorted.map(|(_, index)| index)
}

impl Instrument {
    /// Every number that changes a step, by its path ([`crate::identity`]), sorted.
    #[must_use]
    pub fn parameters(&self) -> Vec<(String, f64)> {
        let mut list = List { instrument: self, path: String::new(), pairs: Vec::new() };
        list.instrument();
        let mut pairs = list.pairs;
        pairs.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        pairs
    }

    /// The digest of [`Instrument::parameters`]: two instruments of one digest move alike, and continue each other's
    /// saved states.
    #[must_use]
    pub fn digest(&self) -> u64 {
        let bytes = |(path, value): &(String, f64)| {
            let value = value.to_bits().to_le_bytes();
            path.bytes().chain([0]).chain(value).collect::<Vec<u8>>()
        };
        fnv1a(FNV1A, self.parameters().iter().flat_map(bytes))
    }
}

/// The pairs so far, and the path that further keys are appended to.
struct List<'a> {
    instrument: &'a Instrument,
    path: String,
    pairs: Vec<(String, f64)>,
}

// The patterns name every field: what is added to a type below must be listed here, or said to change no step.
impl List<'_> {
    fn within(&mut self, key: &str, list: impl FnOnce(&mut Self)) {
        let length = self.path.len();
        if length > 0 {
            self.path.push('.');
        }
        self.path.push_str(key);
        list(self);
        self.path.truncate(length);
    }

    fn number(&mut self, key: &str, value: f64) {
        if value != 0.0 {
            self.within(key, |list| list.pairs.push((list.path.clone(), value)));
        }
    }

    fn vector(&mut self, key: &str, [x, y]: Vec2) {
        self.within(key, |list| {
            list.number("x", x);
            list.number("y", y);
        });
    }

    /// A reference; `None` is the ground or an absent part.
    fn body(&mut self, key: &str, body: Option<usize>) {
        if let Some(body) = body.and_then(|body| self.instrument.bodies.get(body)) {
            self.within(key, |list| list.number(&body.name, 1.0));
        }
    }

    fn zone_named(&mut self, key: &str, zone: Option<usize>) {
        if let Some(zone) = zone.and_then(|zone| self.instrument.zones.get(zone)) {
            self.within(key, |list| list.number(&zone.name, 1.0));
        }
    }

    fn instrument(&mut self) {
        let InstrumentFields {
            name: _,
            gravity_m_per_s2,
            bodies,
            springs,
            zones,
            strings,
            bridge_modes,
            roles,
            finger,
            screws: _,
            parts: _,
            origin: _,
        } = &**self.instrument;
        self.number("gravity_m_s2", *gravity_m_per_s2);
        self.within("body", |list| bodies.iter().for_each(|body| list.within(&body.name, |list| list.of_body(body))));
        self.within("spring", |list| {
            springs.iter().for_each(|spring| list.within(&spring.name, |list| list.of_spring(spring)));
        });
        self.within("zone", |list| zones.iter().for_each(|zone| list.within(&zone.name, |list| list.of_zone(zone))));
        self.within("roles", |list| list.of_roles(roles));
        if roles.key.is_some() {
            let Finger { stiffness_n_per_m, damping_n_s_per_m } = finger;
            self.within("finger", |list| {
                list.number("stiffness_N_per_m", *stiffness_n_per_m);
                list.number("damping_N_s_per_m", *damping_n_s_per_m);
            });
        }
        if self.instrument.has_yielding_strings() {
            self.within("string", |list| {
                strings.iter().for_each(|string| list.within(&string.name, |list| list.of_string(string)));
            });
            if !roles.rigid_bridge {
                self.within("bridge_mode", |list| bridge_modes.iter().for_each(|mode| list.of_bridge_mode(mode)));
            }
        }
    }

    fn of_body(&mut self, body: &Body) {
        let Body {
            name: _,
            parent,
            pivot_m,
            angle_rad,
            mass_kg,
            inertia_kg_m2,
            center_of_mass_m,
            friction_torque_n_m,
            viscous_n_m_s,
            dwell,
            is_bend: _,
            turn_rad: _,
        } = body;
        self.body("hinged_on", *parent);
        self.vector("pivot_m", *pivot_m);
        self.number("angle_rad", *angle_rad);
        self.number("mass_kg", *mass_kg);
        self.number("inertia_kg_m2", *inertia_kg_m2);
        self.vector("center_of_mass_m", *center_of_mass_m);
        self.number("friction_torque_N_m", *friction_torque_n_m);
        self.number("viscous_N_m_s", *viscous_n_m_s);
        self.dwell(*dwell);
    }

    fn dwell(&mut self, dwell: Option<Dwell>) {
        if let Some(Dwell { ratio, time_s }) = dwell {
            self.number("static_friction_ratio", ratio);
            self.number("dwell_s", time_s);
        }
    }

    fn of_spring(&mut self, spring: &Spring) {
        let Spring { name: _, body, torque_n_m, stiffness_n_m_per_rad } = spring;
        self.body("body", Some(*body));
        self.number("torque_N_m", *torque_n_m);
        self.number("stiffness_N_m_per_rad", *stiffness_n_m_per_rad);
    }

    fn of_zone(&mut self, zone: &Zone) {
        let Zone {
            name: _,
            label: _,
            disc_body,
            disc_center_m,
            disc_radius_m,
            curve_body,
            curve,
            felt,
            friction_coefficient,
            dwell,
        } = zone;
        self.within("disc", |list| {
            list.body("body", *disc_body);
            list.vector("center_m", *disc_center_m);
            list.number("radius_m", *disc_radius_m);
        });
        let kind = match curve {
            Curve::Line { .. } => "line",
            Curve::Segment { .. } => "segment",
            Curve::Disc { .. } => "other_disc",
        };
        self.within(kind, |list| {
            list.body("body", *curve_body);
            match *curve {
                Curve::Line { point_m, normal } => {
                    list.vector("point_m", point_m);
                    list.vector("normal", normal);
                }
                Curve::Segment { from_m, to_m, rounding_m } => {
                    list.vector("from_m", from_m);
                    list.vector("to_m", to_m);
                    list.number("rounding_m", rounding_m);
                }
                Curve::Disc { center_m, radius_m } => {
                    list.vector("center_m", center_m);
                    list.number("radius_m", radius_m);
                }
            }
        });
        self.within("felt", |list| list.of_felt(felt));
        self.number("friction_coefficient", *friction_coefficient);
        self.dwell(*dwell);
    }

    fn of_felt(&mut self, felt: &Felt) {
        let Felt { stiffness, exponent, loss, thickness_m: _ } = *felt;
        self.number("stiffness_N_per_m_r", stiffness);
        self.number("exponent", exponent);
        for (number, value) in loss.table().iter().zip(loss.numbers()) {
            self.number(number.key, value * number.units_per_si);
        }
    }

    fn of_roles(&mut self, roles: &Roles) {
        let Roles {
            key,
            key_front_m,
            is_sharp: _,
            hammer,
            hammer_strike_point_m,
            key_bottom: _,
            string,
            rigid_string: _,
            rigid_bridge: _,
            pedal,
            let_off: _,
            knuckle: _,
            check: _,
            transmits: _,
            stops: _,
        } = roles;
        self.body("key", *key);
        if key.is_some() {
            self.vector("key_front_m", *key_front_m);
        }
        self.body("hammer", *hammer);
        if hammer.is_some() {
            self.vector("hammer_head_m", *hammer_strike_point_m);
        }
        self.zone_named("string", *string);
        if self.instrument.has_yielding_strings() {
            self.zone_named("pedal", *pedal);
        }
    }

    fn of_string(&mut self, string: &PianoString) {
        let PianoString {
            name: _,
            length_m,
            mass_kg_per_m,
            tension_n,
            bending_n_m2,
            loss_per_s,
            loss_s,
            strike_m,
            strike_share,
            strike_angle_rad,
            damper,
        } = string;
        self.number("length_m", *length_m);
        self.number("mass_kg_per_m", *mass_kg_per_m);
        self.number("tension_N", *tension_n);
        self.number("bending_N_m2", *bending_n_m2);
        self.number("loss_per_s", *loss_per_s);
        self.number("loss_s", *loss_s);
        self.number("strike_m", *strike_m);
        // Only their ratios count.
        let strings = &self.instrument.strings;
        let all: f64 = strings.iter().map(|string| string.strike_share).sum();
        let share = strike_share * strings.len() as f64 / all;
        if share != 1.0 {
            self.number("strike_share", share);
        }
        if let Some(angle) = strike_angle_rad {
            self.number("strike_angle_rad", *angle);
        }
        if let Some(DamperFelt { zone, middle_m, length_m }) = damper {
            self.within("damper", |list| {
                list.zone_named("zone", Some(*zone));
                list.number("middle_m", *middle_m);
                list.number("length_m", *length_m);
            });
        }
    }

    fn of_bridge_mode(&mut self, mode: &BridgeMode) {
        let BridgeMode { name, mass_kg, frequency_hz, loss_factor, horizontal } = mode;
        self.within(name, |list| {
            list.number("mass_kg", *mass_kg);
            list.number("frequency_Hz", *frequency_hz);
            list.number("loss_factor", *loss_factor);
            if *horizontal != 0.0 {
                list.number("horizontal", *horizontal);
            }
        });
    }
}
