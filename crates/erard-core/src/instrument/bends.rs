//! Parts that bend: the pieces of a part, the hinges that represent the bending of its wood, and the rigid part that
//! the pieces form when these hinges are locked.
//!
//! A bend is a hinge between two rigid pieces with the stiffness that the part has there (a pseudo-rigid-body model): a
//! key at its fulcrum, a shank beyond the knuckle. Code that needs the part's geometry or its weights, without its
//! compliance, locks the bends ([`Instrument::locked`]): the pieces become one rigid body, as drawn.

use super::placement::Placement;
use super::{Body, Curve, DrawnPart, Instrument, InstrumentFields, Roles, Screw, ScrewAction, Spring, Vec2, Zone};
use crate::index::IndexError;

impl Instrument {
    /// Whether any part bends.
    #[must_use]
    pub fn has_bends(&self) -> bool {
        self.bodies.iter().any(|body| body.is_bend)
    }

    /// Returns the first piece of the part that a body belongs to: the piece whose own hinge is not a bend. A body that
    /// is not hinged by a bend is its own first piece.
    ///
    /// # Errors
    /// There is no such body.
    pub fn first_piece(&self, body: usize) -> Result<usize, IndexError> {
        IndexError::check("body", body, self.bodies.len())?;
        Ok(self.first_piece_of(body))
    }

    /// [`Instrument::first_piece`] of a body that exists.
    pub(crate) fn first_piece_of(&self, mut body: usize) -> usize {
        while self.bodies[body].is_bend {
            let Some(parent) = self.bodies[body].parent else { break };
            body = parent;
        }
        body
    }

    /// Returns the instrument whose driven point is on the key's first piece, at the place of the front: a prescribed
    /// key motion moves the piece on the balance pin, and the front bends as it likes. A sensor behind the pin, whose
    /// readings are referred to the front, sees that point while the pivot does not move
    /// ([`Instrument::key_back_misreads`]). Not bent, it is the front. A key that lies is held down
    /// ([`Instrument::with_held_key`]): what is imposed on it could lift its pivot.
    #[must_use]
    pub fn driven_at_key_back(&self) -> Instrument {
        let mut fields = self.with_held_key().fields;
        if let Some(key) = fields.roles.key {
            fields.roles.key_front_m = self.placement_on_first(key).to_world(fields.roles.key_front_m);
            fields.roles.key = Some(self.first_piece_of(key));
        }
        Instrument { fields }
    }

    /// By how much a sensor behind the balance pin, calibrated at the front, reads the key's travel too large for each
    /// metre that the key's pivot rises, m/m: one metre at the front, and what the lever makes of one at the key's end.
    /// The end is the farthest contact behind the pivot; without one, it is as far from it as the front.
    #[must_use]
    pub fn key_back_misreads(&self) -> f64 {
        let Some(key) = self.roles.key else { return 0.0 };
        let first = self.first_piece_of(key);
        let front_m = self.placement_on_first(key).to_world(self.roles.key_front_m)[0];
        let contacts = self.zones.iter().filter(|zone| zone.disc_body == Some(first)).map(|zone| zone.disc_center_m[0]);
        let end_m = contacts.map(|x_m| -x_m * front_m.signum()).fold(0.0, f64::max);
        1.0 + if end_m > 0.0 { front_m.abs() / end_m } else { 1.0 }
    }

    /// Placement of a piece's frame in the frame of its part's first piece, as drawn.
    ///
    /// # Errors
    /// There is no such body.
    pub fn on_first_piece(&self, piece: usize) -> Result<Placement, IndexError> {
        IndexError::check("body", piece, self.bodies.len())?;
        Ok(self.placement_on_first(piece))
    }

    fn placement_on_first(&self, piece: usize) -> Placement {
        let body = &self.bodies[piece];
        if !body.is_bend {
            return Placement::GROUND;
        }
        let (place, drawn) =
            body.parent.map_or((Placement::GROUND, 0.0), |p| (self.placement_on_first(p), self.bodies[p].angle_rad));
        Placement { pivot_m: place.to_world(body.pivot_m), angle_rad: place.angle_rad + body.angle_rad - drawn }
    }

    /// Whether two bodies are pieces of one part.
    ///
    /// # Errors
    /// One of them does not exist.
    pub fn is_same_part(&self, a: usize, b: usize) -> Result<bool, IndexError> {
        Ok(self.first_piece(a)? == self.first_piece(b)?)
    }

    /// Returns the instrument with all bends locked as drawn. The pieces of a part become one rigid body, in the frame
    /// of the first piece, with their masses and moments of inertia (Steiner's theorem). This body has the name of the
    /// piece that is key or hammer, otherwise the name of the first piece.
    ///
    /// The dry torques, damping and springs of the bends are left out, and so are the screws that act on these springs.
    #[must_use]
    pub fn locked(&self) -> Instrument {
        if !self.has_bends() {
            return self.clone();
        }
        let count = self.bodies.len();
        // For every piece: the index of the rigid body that it joins, and its placement in that body's frame.
        let mut becomes = vec![None; count];
        let placed: Vec<Placement> = (0..count).map(|piece| self.placement_on_first(piece)).collect();
        let mut bodies: Vec<Body> = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            // The rigid body that carries the hinge (or the ground), and the placement of the carrying piece in its
            // frame.
            let (on, place) = body.parent.map_or((None, Placement::GROUND), |p| (becomes[p], placed[p]));
            if !body.is_bend {
                becomes[i] = Some(bodies.len());
                bodies.push(Body { parent: on, pivot_m: place.to_world(body.pivot_m), ..body.clone() });
                continue;
            }
            becomes[i] = on;
            // The arm of a bushing on the ground is a piece of the ground.
            let Some(whole) = on.map(|on| &mut bodies[on]) else { continue };
            add(whole, body, placed[i].to_world(body.center_of_mass_m));
            if self.roles.key == Some(i) || self.roles.hammer == Some(i) {
                whole.name.clone_from(&body.name);
            }
        }
        let rigid = Rigid { becomes, placed };
        let (springs, kept) = rigid.springs(self);
        let roles = &self.roles;
        let on = |body: Option<usize>, point: Vec2| body.map_or(point, |body| rigid.placed[body].to_world(point));
        let fields = InstrumentFields {
            name: self.name.clone(),
            gravity_m_per_s2: self.gravity_m_per_s2,
            springs,
            zones: self.zones.iter().map(|zone| rigid.zone(zone)).collect(),
            strings: self.strings.clone(),
            bridge_modes: self.bridge_modes.clone(),
            roles: Roles {
                key: rigid.body(roles.key),
                key_front_m: on(roles.key, roles.key_front_m),
                hammer: rigid.body(roles.hammer),
                hammer_strike_point_m: on(roles.hammer, roles.hammer_strike_point_m),
                ..roles.clone()
            },
            finger: self.finger,
            screws: self.screws.iter().filter_map(|screw| rigid.screw(self, screw, &kept)).collect(),
            parts: self.parts.iter().map(|part| rigid.part(part)).collect(),
            bodies,
            origin: self.origin,
        };
        Instrument { fields }
    }
}

/// Adds the mass and inertia of a piece to a rigid body. `center` is the piece's centre of mass in that body's frame,
/// m.
fn add(whole: &mut Body, piece: &Body, center: Vec2) {
    let square = |[x, y]: Vec2| x * x + y * y;
    let about_center = piece.inertia_kg_m2 - piece.mass_kg * square(piece.center_of_mass_m);
    whole.inertia_kg_m2 += about_center + piece.mass_kg * square(center);
    let mass_kg = whole.mass_kg + piece.mass_kg;
    for (own, other) in whole.center_of_mass_m.iter_mut().zip(center) {
        *own = (whole.mass_kg * *own + piece.mass_kg * other) / mass_kg;
    }
    whole.mass_kg = mass_kg;
}

/// The rigid body that each piece joins, and the placement of each piece in it.
struct Rigid {
    becomes: Vec<Option<usize>>,
    placed: Vec<Placement>,
}

impl Rigid {
    fn body(&self, body: Option<usize>) -> Option<usize> {
        body.and_then(|body| self.becomes[body])
    }

    fn place(&self, body: Option<usize>) -> Placement {
        body.map_or(Placement::GROUND, |body| self.placed[body])
    }

    fn zone(&self, zone: &Zone) -> Zone {
        let (disc, curve) = (self.place(zone.disc_body), self.place(zone.curve_body));
        Zone {
            disc_body: self.body(zone.disc_body),
            disc_center_m: disc.to_world(zone.disc_center_m),
            curve_body: self.body(zone.curve_body),
            curve: match zone.curve {
                Curve::Line { point_m, normal } => {
                    Curve::Line { point_m: curve.to_world(point_m), normal: curve.direction_to_world(normal) }
                }
                Curve::Segment { from_m, to_m, rounding_m } => {
                    Curve::Segment { from_m: curve.to_world(from_m), to_m: curve.to_world(to_m), rounding_m }
                }
                Curve::Disc { center_m, radius_m } => Curve::Disc { center_m: curve.to_world(center_m), radius_m },
            },
            ..zone.clone()
        }
    }

    /// Returns the springs that do not belong to bends, and the new index of every old spring that is kept.
    fn springs(&self, instrument: &Instrument) -> (Vec<Spring>, Vec<Option<usize>>) {
        let (mut springs, mut kept) = (Vec::new(), Vec::new());
        for spring in &instrument.springs {
            let body = self.becomes[spring.body].filter(|_| !instrument.bodies[spring.body].is_bend);
            kept.push(body.map(|_| springs.len()));
            if let Some(body) = body {
                springs.push(Spring { body, ..spring.clone() });
            }
        }
        (springs, kept)
    }

    fn screw(&self, instrument: &Instrument, screw: &Screw, springs: &[Option<usize>]) -> Option<Screw> {
        let action = match screw.action {
            ScrewAction::Disc { zone, direction } => {
                let place = self.place(instrument.zones[zone].disc_body);
                ScrewAction::Disc { zone, direction: place.direction_to_world(direction) }
            }
            ScrewAction::Curve { zone, direction } => {
                let place = self.place(instrument.zones[zone].curve_body);
                ScrewAction::Curve { zone, direction: place.direction_to_world(direction) }
            }
            ScrewAction::Turn { zone } => ScrewAction::Turn { zone },
            ScrewAction::Spring { spring } => ScrewAction::Spring { spring: springs[spring]? },
        };
        Some(Screw { action, ..screw.clone() })
    }

    fn part(&self, part: &DrawnPart) -> DrawnPart {
        let place = self.place(part.body);
        DrawnPart {
            body: self.body(part.body),
            outline_m: part.outline_m.iter().map(|&corner| place.to_world(corner)).collect(),
            ..part.clone()
        }
    }
}
