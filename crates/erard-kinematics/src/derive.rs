//! Derives three levers from an instrument file, the file from which a key press is simulated.
//!
//! The levers are placed as the instrument rests, friction and felts included. Whippen, jack and repetition lever turn
//! as one body, as they do until the jack's toe touches its button. A felt that is compressed at rest keeps its
//! thickness. A contact that is open at rest (a jack just below a knuckle carried by the repetition lever) is closed
//! first, because the levers work only after that play is taken up.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::three_lever::{
    DiscLevers, Lengths, LeverTrain, Line, Regulation, StrokePose, ThreeLever, ThreeLeverError, Touch,
};

use super::case::{Design, LetOff};
use super::file::USUAL_LET_OFF_M;
use erard::instrument::{Curve, Instrument, Placement, Vec2, Zone};
use erard::mechanism::Mechanism;
use erard::player::{Action, ActionError};
use moreau::vector::{add, dot, scale, sub};

/// Play at rest that is worth telling, m.
const NOTABLE_PLAY_M: f64 = 1e-5;

/// Error: three levers cannot be derived from an instrument.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeriveError {
    /// A part is missing or is not as three levers require.
    #[error("the instrument has no three levers: {0}")]
    NotThreeLevers(#[from] NotThreeLevers),
    /// The action could not be assembled, or found no rest.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// The levers do not reach each other.
    #[error(transparent)]
    Levers(#[from] ThreeLeverError),
}

/// Reason why an instrument is not a mechanism of three levers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotThreeLevers {
    /// No body or zone has a required role.
    #[error("`roles` names no {role}")]
    NoRole {
        /// Key of the role in the instrument file.
        role: &'static str,
    },
    /// The key front lies behind the balance pin.
    #[error("the finger presses the key behind its pivot; expected a point in front of it")]
    FingerBehindPivot,
    /// A lever is hinged on another body instead of the ground.
    #[error("`{body}` is not hinged on the ground")]
    NotOnTheGround {
        /// Name of the lever.
        body: String,
    },
    /// No zone of `roles.knuckle` is between a body and the hammer.
    #[error("`roles.knuckle` names no zone in which a body pushes the hammer")]
    NobodyPushesTheHammer,
    /// No whippen carries the part that pushes the knuckle.
    #[error("`{body}` pushes the knuckle without a whippen")]
    NoWhippen {
        /// Name of the pushing body.
        body: String,
    },
    /// No zone connects key and whippen.
    #[error("no zone between `{key}` and `{whippen}`")]
    NoCapstan {
        /// Name of the key.
        key: String,
        /// Name of the whippen.
        whippen: String,
    },
    /// A contact is a disc on a disc, so that there is no straight line to slide on.
    #[error("zone `{zone}` is a disc on a disc, and a straight line is needed")]
    DiscOnDisc {
        /// Name of the zone.
        zone: String,
    },
}

/// Three levers derived from an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// Design: the levers with their discs, and let-off.
    pub design: Design,
    /// Levers of the design ([`Design::levers`]).
    pub levers: DiscLevers,
    /// Closest levers with lengths L1 to L10. Knuckle and jack are exact (the knuckle's centre slides on a line
    /// parallel to the jack's top). The capstan is replaced by the point of the heel that it touches at rest, sliding
    /// on a straight key.
    pub lengths: ThreeLever,
    /// Name of the zone between key and whippen.
    pub capstan_zone: String,
    /// Name of the zone between jack and hammer.
    pub knuckle_zone: String,
    /// Remarks about the instrument at rest, one sentence each.
    pub notes: Vec<String>,
}

/// The instrument at rest.
struct AtRest<'i> {
    instrument: &'i Instrument,
    mechanism: &'i dyn Mechanism,
}

/// Derives the three levers of an instrument as rigid bodies: bends are locked.
///
/// Key and hammer are those of `roles`. The whippen is the body on the ground that carries (or is) the pusher of the
/// knuckle. The knuckle's zone is the zone of `roles.knuckle` whose pusher touches the let-off button, or the first
/// one. The capstan's zone is the zone between key and whippen; if there are several, the most compressed one.
///
/// # Errors
/// Returns an error if a part is missing, the instrument finds no rest, or a contact is a disc on a disc.
pub fn derive(instrument: &Instrument) -> Result<Derived, DeriveError> {
    let instrument = &instrument.locked();
    let roles = &instrument.roles;
    let Some(key) = roles.key else { return Err(NotThreeLevers::NoRole { role: "key" }.into()) };
    let Some(hammer) = roles.hammer else { return Err(NotThreeLevers::NoRole { role: "hammer" }.into()) };
    let parts = Parts::find(instrument, key, hammer)?;

    let action = Action::new(instrument)?;
    let rest = AtRest { instrument, mechanism: action.mechanism() };
    let capstan_zone = parts.capstan_zone(&rest)?;

    let place = |body: usize, turned: f64| Placement {
        pivot_m: rest.mechanism.point(Some(body), [0.0; 2]),
        angle_rad: rest.mechanism.readout().angles[body] + turned,
    };
    // The key's x axis is its surface's normal.
    let key_place = place(key, FRAC_PI_2);
    let (whippen_place, hammer_place) = (place(parts.whippen, 0.0), place(hammer, 0.0));
    let front = rest.mechanism.point(Some(key), roles.key_front_m);
    // The arm's level part: what the finger goes down is this times the key's turning.
    let key_front = key_place.pivot_m[0] - front[0];
    if key_front <= 0.0 {
        return Err(NotThreeLevers::FingerBehindPivot.into());
    }
    let mut notes = Vec::new();
    let whippen = (parts.whippen, whippen_place);
    let capstan = rest.touch(capstan_zone, whippen, key_place, [1.0, -1.0])?;
    let knuckle = rest.touch(parts.knuckle_zone, whippen, hammer_place, [-1.0, 1.0])?;
    rest.tell_play(capstan_zone, &mut notes);
    rest.tell_play(parts.knuckle_zone, &mut notes);
    let from_key = |point: Vec2| sub(point, key_place.pivot_m);
    let levers = DiscLevers {
        whippen_pivot: from_key(whippen_place.pivot_m),
        hammer_pivot: from_key(hammer_place.pivot_m),
        capstan,
        knuckle,
        key_front,
        key_rest: key_place.angle_rad,
        head: roles.hammer_strike_point_m,
        near: [whippen_place.angle_rad, hammer_place.angle_rad],
    };
    let train = levers.assemble()?;
    let let_off = rest.let_off(whippen, &levers, &train, key_place.pivot_m)?;
    let design = Design { name: instrument.name.clone(), levers: levers.into(), let_off };
    if let Some(key) = design.case(&[], Regulation::AsMoved)?.let_off_key_m {
        let poses = train.stroke(0.0, key, 100).poses;
        rest.tell_end_of_face(&instrument.zones[parts.knuckle_zone], whippen, &levers, &poses, &mut notes);
    }
    Ok(Derived {
        lengths: nearest_lengths(&levers, &train.rest()),
        design,
        levers,
        capstan_zone: instrument.zones[capstan_zone].name.clone(),
        knuckle_zone: instrument.zones[parts.knuckle_zone].name.clone(),
        notes,
    })
}

/// Roles of bodies and zones.
struct Parts {
    key: usize,
    whippen: usize,
    knuckle_zone: usize,
}

fn is_between(zone: &Zone, a: Option<usize>, b: Option<usize>) -> bool {
    (zone.disc_body, zone.curve_body) == (a, b) || (zone.disc_body, zone.curve_body) == (b, a)
}

fn other_than(zone: &Zone, body: usize) -> Option<usize> {
    if zone.disc_body == Some(body) { zone.curve_body } else { zone.disc_body }
}

impl Parts {
    fn find(instrument: &Instrument, key: usize, hammer: usize) -> Result<Self, DeriveError> {
        let (roles, zones) = (&instrument.roles, &instrument.zones);
        let bodies = &instrument.bodies;
        for body in [key, hammer] {
            if bodies[body].parent.is_some() {
                return Err(NotThreeLevers::NotOnTheGround { body: bodies[body].name.clone() }.into());
            }
        }
        let meets_button = |body: Option<usize>| {
            let button = roles.let_off.map(|zone| &zones[zone]);
            body.is_some() && button.is_some_and(|button| button.disc_body == body || button.curve_body == body)
        };
        let pushers = || roles.knuckle.iter().map(|&zone| (zone, other_than(&zones[zone], hammer)));
        let found = pushers().find(|(_, body)| meets_button(*body)).or_else(|| pushers().next());
        let Some((knuckle_zone, Some(pusher))) = found else {
            return Err(NotThreeLevers::NobodyPushesTheHammer.into());
        };
        let mut whippen = pusher;
        while let Some(parent) = bodies[whippen].parent {
            whippen = parent;
        }
        if whippen == key || whippen == hammer {
            return Err(NotThreeLevers::NoWhippen { body: bodies[pusher].name.clone() }.into());
        }
        Ok(Parts { key, whippen, knuckle_zone })
    }

    fn capstan_zone(&self, rest: &AtRest<'_>) -> Result<usize, DeriveError> {
        let zones = rest.instrument.zones.iter().enumerate();
        let between = zones.filter(|(_, zone)| is_between(zone, Some(self.key), Some(self.whippen)));
        match between.map(|(zone, _)| zone).max_by(|&a, &b| rest.compression(a).total_cmp(&rest.compression(b))) {
            Some(zone) => Ok(zone),
            None => {
                let name = |body: usize| rest.instrument.bodies[body].name.clone();
                Err(NotThreeLevers::NoCapstan { key: name(self.key), whippen: name(self.whippen) }.into())
            }
        }
    }
}

impl AtRest<'_> {
    /// Compression of a zone, m; negative where it is open.
    fn compression(&self, zone: usize) -> f64 {
        self.mechanism.compression(zone)
    }

    /// Whether a body is the whippen or rides on it.
    fn rides_on(&self, whippen: usize, mut body: Option<usize>) -> bool {
        while let Some(b) = body {
            if b == whippen {
                return true;
            }
            body = self.instrument.bodies[b].parent;
        }
        false
    }

    /// A zone's disc and line in the frames of the two levers at rest. The line is directed away from the player (+1)
    /// or toward him (-1), as `senses` says for a line on the whippen and one on the other lever.
    fn touch(
        &self,
        zone_index: usize,
        (whippen_body, whippen): (usize, Placement),
        other: Placement,
        senses: [f64; 2],
    ) -> Result<Touch, DeriveError> {
        let zone = &self.instrument.zones[zone_index];
        let disc_on_whippen = self.rides_on(whippen_body, zone.disc_body);
        let (disc, line, sense) =
            if disc_on_whippen { (whippen, other, senses[1]) } else { (other, whippen, senses[0]) };
        let center = self.mechanism.point(zone.disc_body, zone.disc_center_m);
        let (point, normal) = self.surface(zone, center)?;
        // Left of this direction is the side that the normal points to.
        let along = [normal[1], -normal[0]];
        let turned = if along[0] * sense < 0.0 { -1.0 } else { 1.0 };
        let [x, y] = line.direction_from_world(along.map(|c| turned * c));
        Ok(Touch {
            disc_on_whippen,
            center: disc.from_world(center),
            offset: turned * (zone.disc_radius_m - self.compression(zone_index).max(0.0)),
            line: Line { point: line.from_world(point), angle: y.atan2(x) },
        })
    }

    /// A point of a zone's straight surface and its outward normal, in the world.
    fn surface(&self, zone: &Zone, center: Vec2) -> Result<(Vec2, Vec2), DeriveError> {
        let at = |point| self.mechanism.point(zone.curve_body, point);
        match zone.curve {
            Curve::Line { point_m, normal } => {
                let (foot, tip) = (at(point_m), at([point_m[0] + normal[0], point_m[1] + normal[1]]));
                Ok((foot, sub(tip, foot)))
            }
            Curve::Segment { from_m, to_m, rounding_m } => {
                let (from, to) = (at(from_m), at(to_m));
                let [x, y] = sub(to, from);
                let length = x.hypot(y);
                let normal = [-y / length, x / length];
                let height = dot(sub(center, from), normal);
                let normal = normal.map(|n| n.copysign(n * height));
                Ok((add(from, scale(normal, rounding_m)), normal))
            }
            Curve::Disc { .. } => Err(NotThreeLevers::DiscOnDisc { zone: zone.name.clone() }.into()),
        }
    }

    /// A remark about a contact that is open at rest.
    fn tell_play(&self, zone: usize, notes: &mut Vec<String>) {
        let play = -self.compression(zone);
        if play > NOTABLE_PLAY_M {
            let label = &self.instrument.zones[zone].label;
            notes.push(format!("at rest {label} is open by {:.2} mm; the levers have this play closed", play * 1e3));
        }
    }

    /// Let-off: where the toe meets its button, or, without a button, the usual distance below the string.
    fn let_off(
        &self,
        whippen: (usize, Placement),
        levers: &DiscLevers,
        train: &LeverTrain,
        origin: Vec2,
    ) -> Result<Option<LetOff>, DeriveError> {
        let roles = &self.instrument.roles;
        let rest = train.rest();
        if let Some(zone_index) = roles.let_off {
            let zone = &self.instrument.zones[zone_index];
            let on_whippen = |body| self.rides_on(whippen.0, body);
            if on_whippen(zone.disc_body) != on_whippen(zone.curve_body) {
                let ground = Placement { pivot_m: origin, angle_rad: 0.0 };
                let stop = self.touch(zone_index, whippen, ground, [1.0, 1.0])?;
                let key = levers.key_travel_to_stop(&rest, &stop).filter(|key| *key > 0.0);
                let pose = key.and_then(|key| train.stroke(0.0, key, 1).poses.into_iter().nth(1));
                return Ok(pose.map(|pose| LetOff {
                    head_height_m: train.rest_head_height() + pose.head_rise,
                    name: "toe contact",
                    what: format!("contact of {}, where the jack begins to escape", zone.label),
                }));
            }
        }
        Ok(roles.string.map(|string| -self.compression(string) - USUAL_LET_OFF_M).filter(|rise| *rise > 0.0).map(
            |rise| LetOff {
                head_height_m: train.rest_head_height() + rise,
                name: "let-off",
                what: format!("hammer head {:.1} mm below the string", USUAL_LET_OFF_M * 1e3),
            },
        ))
    }

    /// A remark if the knuckle leaves the straight part of the jack's top at one of the poses.
    fn tell_end_of_face(
        &self,
        zone: &Zone,
        (whippen_body, whippen): (usize, Placement),
        levers: &DiscLevers,
        poses: &[StrokePose],
        notes: &mut Vec<String>,
    ) {
        let Curve::Segment { from_m, to_m, .. } = zone.curve else { return };
        if !self.rides_on(whippen_body, zone.curve_body) {
            return;
        }
        let [from, to] = [from_m, to_m].map(|end| whippen.from_world(self.mechanism.point(zone.curve_body, end)));
        let along = sub(to, from);
        let off = poses.iter().find(|pose| {
            let [_, contact] = levers.contact_points(pose);
            let at = Placement { pivot_m: levers.whippen_pivot, angle_rad: pose.w }.from_world(contact);
            let part = dot(sub(at, from), along) / dot(along, along);
            !(0.0..=1.0).contains(&part)
        });
        if let Some(pose) = off {
            notes.push(format!(
                "at key {:.2} mm the knuckle stands beyond the end of the jack's face; its line is taken as going on",
                pose.key * 1e3
            ));
        }
    }
}

/// The nearest levers of L1 to L10; see [`Derived::lengths`].
fn nearest_lengths(levers: &DiscLevers, rest: &StrokePose) -> ThreeLever {
    let place = |pivot_m: Vec2, angle_rad: f64| Placement { pivot_m, angle_rad };
    let (key, hammer) = (place([0.0; 2], rest.k), place(levers.hammer_pivot, rest.h));
    let whippen = place(levers.whippen_pivot, rest.w);
    // In the world: which way a contact's line runs, made to point away from the player.
    let slope = |touch: &Touch, other: Placement| {
        let angle = touch.line.angle + if touch.disc_on_whippen { other.angle_rad } else { whippen.angle_rad };
        angle.sin().atan2(angle.cos()) + if angle.cos() < 0.0 { PI.copysign(-angle.sin()) } else { 0.0 }
    };
    let [capstan, knuckle] = levers.contact_points(rest);
    // The knuckle slides by its centre where the jack carries the line.
    let knuckle = if levers.knuckle.disc_on_whippen { knuckle } else { hammer.to_world(levers.knuckle.center) };
    // L1 to L10 measure the whippen's turning from the jack's top.
    let jack_top = place(whippen.pivot_m, slope(&levers.knuckle, hammer));
    let surface = place([0.0; 2], slope(&levers.capstan, key) + FRAC_PI_2);
    let [l3, minus_l4] = jack_top.from_world(capstan);
    let [l8, minus_l9] = hammer.from_world(knuckle);
    let [bx, by] = levers.whippen_pivot;
    let [cx, cy] = levers.hammer_pivot;
    ThreeLever {
        lengths: Lengths::from([
            bx,
            surface.from_world(capstan)[0],
            l3,
            -minus_l4,
            by,
            bx - cx,
            -jack_top.from_world(knuckle)[1],
            l8,
            -minus_l9,
            cy - by,
        ]),
        key_front: levers.key_front,
        key_rest: surface.angle_rad,
        head: levers.head,
    }
}
