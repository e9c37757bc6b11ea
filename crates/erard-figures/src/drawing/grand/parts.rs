//! Which body and which zone of an instrument is which part of a grand action.

use erard::instrument::{Curve, Instrument, Placement, Vec2, Zone};
use serde::Deserialize;

/// A part of the action that is one piece of wood, whether or not the mechanics lets it bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Component {
    Ground,
    PedalRail,
    Key,
    Whippen,
    Jack,
    Lever,
    Hammer,
    Damper,
}

/// Which body and which zone is which. Zones are identified by the bodies that touch.
#[derive(Debug)]
pub(super) struct Parts {
    pub(super) key: Vec<usize>,
    pub(super) whippen: usize,
    pub(super) jack: usize,
    pub(super) lever: Option<usize>,
    pub(super) hammer: Vec<usize>,
    /// The damper, where the key can lift it.
    pub(super) damper: Option<usize>,
    /// The body about whose pivot the key turns.
    pub(super) key_pin: usize,
    pub(super) punching: usize,
    pub(super) back_rail: Option<usize>,
    pub(super) capstan: usize,
    pub(super) jack_knuckle: usize,
    pub(super) lever_knuckle: Option<usize>,
    pub(super) button: usize,
    pub(super) jack_rest: Option<usize>,
    pub(super) lever_stop: Option<usize>,
    pub(super) drop_screw: Option<usize>,
    pub(super) string: usize,
    pub(super) check: Option<usize>,
    pub(super) hammer_rest: Option<usize>,
    pub(super) lift: Option<usize>,
    pub(super) damper_rest: Option<usize>,
    /// What a loud note throws the damper against, and the jack.
    pub(super) damper_stop: Option<usize>,
    pub(super) jack_stop: Option<usize>,
    /// The rail that the sustain pedal lifts, under the damper's lever.
    pub(super) pedal_rail: Option<usize>,
    /// Bodies that are there in the mechanics only: a damper that nothing lifts.
    pub(super) unseen: Vec<usize>,
}

/// How much further than the key goes a damper may be and still be taken for one that it lifts.
const OUT_OF_REACH: f64 = 1.3;

impl Parts {
    /// Finds the parts; `None` for what is no grand action.
    pub(super) fn of(instrument: &Instrument, drawn: &[Placement]) -> Option<Self> {
        let (roles, zones) = (&instrument.roles, &instrument.zones);
        let root = |mut body: usize| {
            while let Some(parent) = instrument.bodies[body].parent {
                body = parent;
            }
            body
        };
        // The arm of a bushing is a device and has no shape.
        let is_piece = |body: &usize, of: usize| root(*body) == root(of) && !instrument.is_arm(*body);
        let all = |of: usize| (0..instrument.bodies.len()).filter(|body| is_piece(body, of)).collect::<Vec<_>>();
        let (key, hammer) = (all(roles.key?), all(roles.hammer?));
        let button = roles.let_off?;
        let jack = zones[button].disc_body?;
        let whippen = instrument.bodies[jack].parent?;
        let pushes = |zone: &usize, by: usize| zones[*zone].curve_body == Some(by);
        let jack_knuckle = roles.knuckle.iter().copied().find(|zone| pushes(zone, jack))?;
        let rides = |zone: &usize| {
            let body = zones[*zone].curve_body;
            body != Some(jack) && body.is_some_and(|body| instrument.bodies[body].parent == Some(whippen))
        };
        let lever_knuckle = roles.knuckle.iter().copied().find(rides);
        let lever = lever_knuckle.and_then(|zone| zones[zone].curve_body);
        if key.contains(&whippen) || hammer.contains(&whippen) || key.iter().any(|body| hammer.contains(body)) {
            return None;
        }
        // The zones whose disc is on one of the bodies `a` and whose curve is on one of `b`; none of them is the
        // ground.
        let between = |a: &[usize], b: &[usize]| {
            let on = |body: Option<usize>, of: &[usize]| body.map_or(of.is_empty(), |body| of.contains(&body));
            let is_it = |zone: &Zone| on(zone.disc_body, a) && on(zone.curve_body, b);
            (0..zones.len()).filter(|&zone| is_it(&zones[zone])).collect::<Vec<_>>().into_iter()
        };
        let capstan = between(&key, &[whippen]).next()?;
        let punching = roles.key_bottom?;
        let lifted = zones.iter().enumerate().find_map(|(index, zone)| {
            let damper = zone
                .disc_body
                .filter(|body| !key.contains(body) && !hammer.contains(body) && root(*body) != root(whippen))?;
            zone.curve_body.is_some_and(|body| key.contains(&body)).then_some((damper, index))
        });
        let key_pin = key_pin(instrument, &key, punching, capstan, drawn);
        let lever_slice = lever.as_slice();
        let mut parts = Parts {
            whippen,
            jack,
            lever,
            damper: None,
            key_pin,
            punching,
            back_rail: between(&key, &[]).filter(|&zone| zone != punching).find(|&zone| {
                let zone = &zones[zone];
                zone.disc_body
                    .is_some_and(|body| drawn[body].to_world(zone.disc_center_m)[0] > drawn[key_pin].pivot_m[0] + 0.05)
            }),
            capstan,
            jack_knuckle,
            lever_knuckle,
            button,
            jack_rest: between(&[jack], &[whippen]).next(),
            lever_stop: lever.and_then(|_| between(lever_slice, &[whippen]).next()),
            drop_screw: lever.and_then(|_| between(lever_slice, &[]).next()),
            string: roles.string?,
            check: roles.check,
            hammer_rest: between(&hammer, &[whippen]).next(),
            lift: None,
            damper_rest: None,
            damper_stop: None,
            jack_stop: between(&[jack], &[whippen]).nth(1),
            pedal_rail: None,
            unseen: Vec::new(),
            key,
            hammer,
        };
        if let Some((damper, lift)) = lifted {
            if parts.reaches(instrument, lift, drawn) {
                (parts.damper, parts.lift) = (Some(damper), Some(lift));
                parts.pedal_rail = between(&[damper], &[]).find(|zone| roles.pedal == Some(*zone));
                let mut stops = between(&[damper], &[]).filter(|zone| roles.pedal != Some(*zone));
                (parts.damper_rest, parts.damper_stop) = (stops.next(), stops.next());
            } else {
                parts.unseen.push(damper);
            }
        }
        let expected = [punching, capstan, button, parts.string];
        let is_usual = expected.iter().all(|&zone| matches!(zones[zone].curve, Curve::Line { .. }))
            && zones[punching].curve_body.is_none()
            && zones[button].curve_body.is_none()
            && zones[parts.string].curve_body.is_none()
            && matches!(zones[jack_knuckle].curve, Curve::Segment { .. });
        is_usual.then_some(parts)
    }

    /// Whether the key's whole way takes it to the damper.
    fn reaches(&self, instrument: &Instrument, lift: usize, drawn: &[Placement]) -> bool {
        let from_pin = |zone: &Zone| drawn_disc(zone, drawn)[0] - drawn[self.key_pin].pivot_m[0];
        let (front, lift) = (&instrument.zones[self.punching], &instrument.zones[lift]);
        clearance(lift, drawn) < OUT_OF_REACH * clearance(front, drawn) * (from_pin(lift) / from_pin(front)).abs()
    }

    /// Which component a body belongs to.
    pub(super) fn component_of(&self, body: Option<usize>) -> Option<Component> {
        let Some(body) = body else { return Some(Component::Ground) };
        let one = |of: Option<usize>, component| (of == Some(body)).then_some(component);
        (self.key.contains(&body).then_some(Component::Key))
            .or(self.hammer.contains(&body).then_some(Component::Hammer))
            .or(one(Some(self.whippen), Component::Whippen))
            .or(one(Some(self.jack), Component::Jack))
            .or(one(self.lever, Component::Lever))
            .or(one(self.damper, Component::Damper))
    }

    /// The frame of a component as drawn: upright at its pin; the hammer's lies along its shank.
    pub(super) fn frame(&self, component: Component, drawn: &[Placement]) -> Placement {
        let upright = |body: usize| Placement { pivot_m: drawn[body].pivot_m, angle_rad: 0.0 };
        match component {
            Component::Ground | Component::PedalRail => Placement::GROUND,
            Component::Key => upright(self.key_pin),
            Component::Whippen => upright(self.whippen),
            Component::Jack => upright(self.jack),
            Component::Lever => self.lever.map_or(Placement::GROUND, upright),
            Component::Damper => self.damper.map_or(Placement::GROUND, upright),
            Component::Hammer => drawn[self.hammer[0]],
        }
    }

    /// The bodies of a component.
    pub(super) fn bodies(&self, component: Component) -> &[usize] {
        match component {
            Component::Ground | Component::PedalRail => &[],
            Component::Key => &self.key,
            Component::Whippen => std::slice::from_ref(&self.whippen),
            Component::Jack => std::slice::from_ref(&self.jack),
            Component::Lever => self.lever.as_slice(),
            Component::Hammer => &self.hammer,
            Component::Damper => self.damper.as_slice(),
        }
    }

    /// The zones whose both sides the outlines show.
    pub(super) fn shown_zones(&self) -> [Option<usize>; 17] {
        [
            Some(self.punching),
            self.back_rail,
            Some(self.capstan),
            Some(self.jack_knuckle),
            self.lever_knuckle,
            Some(self.button),
            self.jack_rest,
            self.lever_stop,
            self.drop_screw,
            Some(self.string),
            self.check,
            self.hammer_rest,
            self.lift,
            self.damper_rest,
            self.damper_stop,
            self.jack_stop,
            self.pedal_rail,
        ]
    }
}

/// The pin that the key turns about: of the pivots of its bodies between its front and the capstan the one nearest to
/// the capstan.
fn key_pin(instrument: &Instrument, key: &[usize], punching: usize, capstan: usize, drawn: &[Placement]) -> usize {
    let front = drawn_disc(&instrument.zones[punching], drawn)[0];
    let capstan = drawn_disc(&instrument.zones[capstan], drawn)[0];
    let pivot = |body: usize| drawn[body].pivot_m[0];
    let between = key.iter().copied().filter(|&body| pivot(body) > front && pivot(body) < capstan);
    between.max_by(|a, b| pivot(*a).total_cmp(&pivot(*b))).unwrap_or(key[0])
}

/// Where a zone's disc is as drawn, m, in the world.
fn drawn_disc(zone: &Zone, drawn: &[Placement]) -> Vec2 {
    zone.disc_body.map_or(Placement::GROUND, |body| drawn[body]).to_world(zone.disc_center_m)
}

/// How far a disc and a line are apart as drawn, m; infinite for other curves.
pub(super) fn clearance(zone: &Zone, drawn: &[Placement]) -> f64 {
    let Curve::Line { point_m, normal } = zone.curve else { return f64::INFINITY };
    let carrier = zone.curve_body.map_or(Placement::GROUND, |body| drawn[body]);
    let [x, y] = carrier.from_world(drawn_disc(zone, drawn));
    (x - point_m[0]) * normal[0] + (y - point_m[1]) * normal[1] - zone.disc_radius_m
}
