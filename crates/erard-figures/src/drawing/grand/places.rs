//! The places of a grand action that its outlines hang on, found from the instrument's geometry as drawn.

use super::parts::{Component, Parts};
use erard::instrument::{Curve, Instrument, Placement, Vec2, Zone};
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// A place of the geometry. Each belongs to one component, whose frame it is given in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Place {
    // on the ground
    Fulcrum,
    FrontRail,
    Punching,
    BackFrame,
    BackRail,
    StringLine,
    WhippenRail,
    HammerRail,
    Button,
    ButtonRail,
    DropScrew,
    DropScrewHead,
    DamperRail,
    DamperRest,
    DamperStop,
    PedalRail,
    // on the key
    KeyPin,
    Balance,
    KeyFront,
    KeyTop,
    KeyBack,
    KeyTail,
    CapstanTop,
    Capstan,
    Lift,
    LiftBase,
    Check,
    // on the whippen
    Whippen,
    Heel,
    JackPin,
    LeverPin,
    JackRest,
    JackStop,
    LeverStop,
    LeverStopBase,
    HammerRest,
    HammerRestBase,
    // on the jack
    Jack,
    JackTopFront,
    JackTopBack,
    Toe,
    JackBack,
    JackFront,
    // on the repetition lever
    Lever,
    LeverFace,
    LeverTail,
    LeverTip,
    // on the hammer
    Hammer,
    Knuckle,
    Strike,
    Head,
    Tail,
    ShankRest,
    // on the damper
    Damper,
    DamperFoot,
    DamperSeat,
    DamperTop,
    DamperPost,
}

/// Where a place is, and how what hangs on it is turned and scaled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Located {
    /// In its component's frame, mm.
    pub at: Vec2,
    /// By which offsets from it are turned, rad.
    pub turn: f64,
    /// By which offsets from it are multiplied.
    pub scale: f64,
}

impl Located {
    fn at(at: Vec2) -> Self {
        Located { at, turn: 0.0, scale: 1.0 }
    }

    /// The place with an offset, mm.
    pub(crate) fn offset(&self, [x, y]: Vec2) -> Vec2 {
        let (sin, cos) = self.turn.sin_cos();
        let [x, y] = [x * self.scale, y * self.scale];
        [self.at[0] + cos * x - sin * y, self.at[1] + sin * x + cos * y]
    }
}

/// Thickness of the key from its underside to its top behind the capstan, mm.
const TAIL_HEIGHT: f64 = 18.6;
/// From capstan to the end of the key where nothing tells, mm.
const BEHIND_CAPSTAN: f64 = 83.0;
/// A line further than this from what meets it is drawn about its own point, mm.
const FAR: f64 = 12.0;

/// Looks places up in an instrument.
pub(super) struct Places<'i> {
    instrument: &'i Instrument,
    parts: &'i Parts,
    drawn: &'i [Placement],
}

impl<'i> Places<'i> {
    pub(crate) fn new(instrument: &'i Instrument, parts: &'i Parts, drawn: &'i [Placement]) -> Self {
        Places { instrument, parts, drawn }
    }

    /// The place, or `None` where the instrument has no such thing.
    pub(crate) fn find(&self, place: Place) -> Option<Located> {
        use Component as C;
        let p = self.parts;
        let level = |at: Vec2| Some(Located::at(at));
        let x_of = |place: Place| self.find(place).map(|found| found.at[0]);
        let y_of = |place: Place| self.find(place).map(|found| found.at[1]);
        match place {
            Place::Fulcrum => level(self.origin(C::Key)),
            Place::FrontRail => level([x_of(Place::Punching)?, self.origin(C::Key)[1]]),
            Place::Punching => self.face(p.punching, C::Ground, 2.0, FRAC_PI_2),
            Place::BackFrame => level([self.origin(C::Key)[0] + x_of(Place::KeyBack)?, self.origin(C::Key)[1]]),
            Place::BackRail => self.face(p.back_rail?, C::Ground, 4.0, FRAC_PI_2),
            Place::StringLine => self.line(p.string, C::Ground, -FRAC_PI_2),
            Place::WhippenRail => level(self.origin(C::Whippen)),
            Place::HammerRail => level(self.origin(C::Hammer)),
            Place::Button => self.met(p.button, 1.5),
            Place::ButtonRail => level([x_of(Place::Button)?, self.origin(C::Hammer)[1]]),
            Place::DropScrew => self.met(p.drop_screw?, 0.0),
            Place::DropScrewHead => level([x_of(Place::DropScrew)?, self.origin(C::Hammer)[1]]),
            Place::DamperRail => p.damper.map(|_| Located::at(self.origin(C::Damper))),
            // A damper that lies on its strings rests on nothing else.
            Place::DamperRest => {
                let rest = p.damper_rest.filter(|&zone| !super::is_on_a_string(self.instrument, zone))?;
                self.face(rest, C::Ground, 4.0, FRAC_PI_2)
            }
            Place::DamperStop => self.face(p.damper_stop?, C::Ground, 3.0, -FRAC_PI_2),
            Place::PedalRail => self.face(p.pedal_rail?, C::Ground, 4.0, FRAC_PI_2),

            Place::KeyPin => level([0.0; 2]),
            Place::Balance => level([0.0, y_of(Place::KeyTop)?]),
            Place::KeyFront => self.disc(p.punching, C::Key).map(|(at, _)| Located::at(at)),
            Place::KeyTop => {
                let key = self.instrument.roles.key?;
                let [x, y] = self.seen(Some(key), self.instrument.roles.key_front_m, C::Key);
                level([x.min(x_of(Place::KeyFront)?), y])
            }
            Place::KeyBack => match p.back_rail.and_then(|zone| self.disc(zone, C::Key)) {
                Some((at, _)) => level(at),
                None => level([x_of(Place::Capstan)? + BEHIND_CAPSTAN, y_of(Place::KeyFront)?.min(0.0)]),
            },
            Place::KeyTail => self.find(Place::KeyBack).map(|back| Located::at([back.at[0], back.at[1] + TAIL_HEIGHT])),
            Place::CapstanTop => level([x_of(Place::Capstan)?, y_of(Place::KeyTop)?]),
            Place::Capstan => self.disc(p.capstan, C::Key).map(|(at, _)| Located::at(at)),
            Place::Lift => {
                p.damper?;
                self.face(p.lift?, C::Key, 4.0, FRAC_PI_2)
            }
            Place::LiftBase => level([x_of(Place::Lift)?, y_of(Place::KeyTail)?.min(y_of(Place::Lift)? - 1.0)]),
            Place::Check => self.caught(p.check?, 8.0),

            Place::Whippen | Place::Jack | Place::Hammer => level([0.0; 2]),
            Place::Lever => p.lever.map(|_| Located::at([0.0; 2])),
            Place::Damper => p.damper.map(|_| Located::at([0.0; 2])),
            Place::Heel => self.face(p.capstan, C::Whippen, 10.0, -FRAC_PI_2),
            Place::JackPin => level(self.hinge(p.jack)),
            Place::LeverPin => level(p.lever.map_or([-42.0, 30.0], |lever| self.hinge(lever))),
            Place::JackRest => self.face(p.jack_rest?, C::Whippen, 3.0, PI),
            Place::JackStop => self.face(p.jack_stop?, C::Whippen, 2.0, 0.0),
            Place::LeverStop => self.face(p.lever_stop?, C::Whippen, 3.0, FRAC_PI_2),
            Place::LeverStopBase => level([x_of(Place::LeverStop).unwrap_or(-22.0), 0.0]),
            Place::HammerRest => self.face(p.hammer_rest?, C::Whippen, 3.0, FRAC_PI_2),
            Place::HammerRestBase => level([x_of(Place::HammerRest).unwrap_or(-9.0), 0.0]),

            Place::JackTopFront => self.top(0),
            Place::JackTopBack => self.top(1),
            Place::Toe => self.disc(p.button, C::Jack).map(|(at, _)| Located::at(at)),
            Place::JackBack => self.disc(p.jack_rest?, C::Jack).map(|(at, _)| Located::at(at)),
            Place::JackFront => self.disc(p.jack_stop?, C::Jack).map(|(at, _)| Located::at(at)),

            Place::LeverFace => self.face(p.lever_knuckle?, C::Lever, 1.0, FRAC_PI_2),
            Place::LeverTail => self.disc(p.lever_stop?, C::Lever).map(|(at, _)| Located::at(at)),
            Place::LeverTip => self.disc(p.drop_screw?, C::Lever).map(|(at, _)| Located::at(at)),

            Place::Knuckle => self.disc(p.jack_knuckle, C::Hammer).map(|(at, _)| Located::at(at)),
            Place::Strike => {
                let (at, _) = self.disc(p.string, C::Hammer)?;
                Some(Located { at, turn: 0.0, scale: super::made::head_scale(self.instrument, self.parts) })
            }
            Place::Head => level([x_of(Place::Strike)?, 0.0]),
            Place::Tail => match p.check.and_then(|check| self.disc(check, C::Hammer)) {
                Some((at, _)) => level(at),
                None => level([x_of(Place::Strike)? + 3.0, -15.0]),
            },
            Place::ShankRest => match p.hammer_rest.and_then(|zone| self.disc(zone, C::Hammer)) {
                Some((at, _)) => level(at),
                None => level([0.7 * x_of(Place::Strike)?, -3.0]),
            },

            Place::DamperFoot => p.lift.and_then(|zone| self.disc(zone, C::Damper)).map(|(at, _)| Located::at(at)),
            Place::DamperSeat => self.disc(p.damper_rest?, C::Damper).map(|(at, _)| Located::at(at)),
            Place::DamperTop => self.disc(p.damper_stop?, C::Damper).map(|(at, _)| Located::at(at)),
            Place::DamperPost => self.disc(p.pedal_rail?, C::Damper).map(|(at, _)| Located::at(at)),
        }
    }

    /// Centre and radius of a zone's disc, mm, in a component's frame.
    pub(crate) fn disc(&self, zone: usize, component: Component) -> Option<(Vec2, f64)> {
        let zone = &self.instrument.zones[zone];
        let is_there = self.parts.component_of(zone.disc_body) == Some(component);
        is_there.then(|| (self.seen(zone.disc_body, zone.disc_center_m, component), 1e3 * zone.disc_radius_m))
    }

    /// A zone's line at its own point, turned as its normal is turned from `level`, rad.
    fn line(&self, zone: usize, component: Component, level: f64) -> Option<Located> {
        let (at, normal) = self.line_of(&self.instrument.zones[zone], component)?;
        Some(Located { at, turn: normal[1].atan2(normal[0]) - level, scale: 1.0 })
    }

    /// As [`Self::line`], moved along the line as far as it takes to lie within `reach` mm of where the disc meets it
    /// as drawn: a line is endless in the mechanics, a felt is not.
    fn face(&self, zone: usize, component: Component, reach: f64, level: f64) -> Option<Located> {
        let mut found = self.line(zone, component, level)?;
        let zone = &self.instrument.zones[zone];
        let (point, normal) = self.line_of(zone, component)?;
        let disc = self.seen(zone.disc_body, zone.disc_center_m, component);
        let away = [disc[0] - point[0], disc[1] - point[1]];
        let height = away[0] * normal[0] + away[1] * normal[1] - 1e3 * zone.disc_radius_m;
        if height.abs() < FAR {
            let tangent = [normal[1], -normal[0]];
            let along = away[0] * tangent[0] + away[1] * tangent[1];
            let beyond = along - along.clamp(-reach, reach);
            found.at = [found.at[0] + beyond * tangent[0], found.at[1] + beyond * tangent[1]];
        }
        Some(found)
    }

    /// A line of the ground above what rides on the whippen, moved along to within `reach` mm of where the risen
    /// whippen takes the disc to it.
    fn met(&self, zone: usize, reach: f64) -> Option<Located> {
        let mut found = self.line(zone, Component::Ground, -FRAC_PI_2)?;
        let zone = &self.instrument.zones[zone];
        let (point, normal) = self.line_of(zone, Component::Ground)?;
        let pin = self.origin(Component::Whippen);
        let drawn = self.seen(zone.disc_body, zone.disc_center_m, Component::Ground);
        let arm = [drawn[0] - pin[0], drawn[1] - pin[1]];
        let along = |rise: f64| {
            let (sin, cos) = rise.sin_cos();
            let away =
                [pin[0] + cos * arm[0] + sin * arm[1] - point[0], pin[1] - sin * arm[0] + cos * arm[1] - point[1]];
            (
                away[0] * normal[0] + away[1] * normal[1] - 1e3 * zone.disc_radius_m,
                away[0] * normal[1] - away[1] * normal[0],
            )
        };
        // The whippen rises (clockwise, for its pin is at the back) by a few degrees at most.
        let (mut open, mut closed) = (0.0, 0.25);
        if along(open).0 > 0.0 && along(closed).0 < 0.0 {
            for _ in 0..40 {
                let middle = 0.5 * (open + closed);
                if along(middle).0 > 0.0 { open = middle } else { closed = middle }
            }
        } else {
            closed = 0.0;
        }
        let along = along(closed).1;
        let beyond = along - along.clamp(-reach, reach);
        found.at = [found.at[0] + beyond * normal[1], found.at[1] - beyond * normal[0]];
        Some(found)
    }

    /// The check's face on the key, moved along to within `reach` mm of where it catches the tail: key down, hammer
    /// falling from the string.
    fn caught(&self, zone: usize, reach: f64) -> Option<Located> {
        let mut found = self.line(zone, Component::Key, 160_f64.to_radians())?;
        let (at, normal) = self.line_of(&self.instrument.zones[zone], Component::Key)?;
        let (tail, radius) = self.disc(zone, Component::Hammer)?;
        let (front, pin) = (&self.instrument.zones[self.parts.punching], self.origin(Component::Key));
        let dip = super::parts::clearance(front, self.drawn) / -self.find(Place::KeyFront)?.at[0] * 1e3;
        let hammer = self.parts.frame(Component::Hammer, self.drawn);
        let on_face = |rise: f64| {
            let risen = Placement { angle_rad: hammer.angle_rad + rise, ..hammer };
            let world = risen.to_world(tail.map(|c| 1e-3 * c));
            let key = Placement { pivot_m: pin.map(|c| 1e-3 * c), angle_rad: dip };
            let [x, y] = key.from_world(world).map(|c| 1e3 * c);
            let away = [x - at[0], y - at[1]];
            (away[0] * normal[0] + away[1] * normal[1] - radius, away[0] * normal[1] - away[1] * normal[0])
        };
        let falling = (0..400).map(|step| 0.5 - 1e-3 * f64::from(step));
        let meets = falling.map(on_face).skip_while(|(open, _)| *open < 0.0).find(|(open, _)| *open < 0.0);
        if let Some((_, along)) = meets {
            let beyond = along - along.clamp(-reach, reach);
            found.at = [found.at[0] + beyond * normal[1], found.at[1] - beyond * normal[0]];
        }
        Some(found)
    }

    /// Point and normal of a zone's line, mm, in a component's frame.
    fn line_of(&self, zone: &Zone, component: Component) -> Option<(Vec2, Vec2)> {
        if self.parts.component_of(zone.curve_body) != Some(component) {
            return None;
        }
        let Curve::Line { point_m, normal } = zone.curve else { return None };
        let at = self.seen(zone.curve_body, point_m, component);
        let tip = self.seen(zone.curve_body, [point_m[0] + 1e-3 * normal[0], point_m[1] + 1e-3 * normal[1]], component);
        Some((at, [tip[0] - at[0], tip[1] - at[1]]))
    }

    /// An end of the jack's top, with its rounding as the scale.
    fn top(&self, end: usize) -> Option<Located> {
        let zone = &self.instrument.zones[self.parts.jack_knuckle];
        if self.parts.component_of(zone.curve_body) != Some(Component::Jack) {
            return None;
        }
        let Curve::Segment { from_m, to_m, rounding_m } = zone.curve else { return None };
        let mut ends = [from_m, to_m].map(|end| self.seen(zone.curve_body, end, Component::Jack));
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let turn = (ends[1][1] - ends[0][1]).atan2(ends[1][0] - ends[0][0]);
        Some(Located { at: ends[end], turn, scale: 1e3 * rounding_m })
    }

    /// Where a body is hinged, mm, in the frame of the component that carries it.
    fn hinge(&self, body: usize) -> Vec2 {
        self.to_frame(self.drawn[body].pivot_m, Component::Whippen)
    }

    /// A component's origin in the world, mm.
    pub(crate) fn origin(&self, component: Component) -> Vec2 {
        self.parts.frame(component, self.drawn).pivot_m.map(|c| 1e3 * c)
    }

    /// A point of a body, mm, in a component's frame as drawn.
    pub(crate) fn seen(&self, body: Option<usize>, point_m: Vec2, component: Component) -> Vec2 {
        let world = body.map_or(Placement::GROUND, |body| self.drawn[body]).to_world(point_m);
        self.to_frame(world, component)
    }

    fn to_frame(&self, world_m: Vec2, component: Component) -> Vec2 {
        self.parts.frame(component, self.drawn).from_world(world_m).map(|c| 1e3 * c)
    }
}
