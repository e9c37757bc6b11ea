//! Writes down a run while it goes on.

use moreau::Contact;

use crate::instrument::Instrument;
use crate::mechanism::Mechanism;
use crate::run::{BodySeries, ZoneSeries};

/// An observer that writes an action's series down: told of every step, and of every instant that makes a row. Units and signs as in
/// [`crate::run::Run`].
#[derive(Debug)]
pub struct Recorder {
    pub(super) time_s: Vec<f64>,
    pub(super) force_n: Vec<f64>,
    pub(super) key_m: Vec<f64>,
    pub(super) hammer_head_m: Vec<f64>,
    pub(super) bodies: Vec<BodySeries>,
    pub(super) zones: Vec<ZoneSeries>,
    has_hammer: bool,
    /// The last row's forces are those of a step of this length, s, and still wait for those of the step after it.
    pending: Option<f64>,
}

impl Recorder {
    /// For so many rows of an instrument: memory for them is taken now.
    pub fn new(instrument: &Instrument, rows: usize) -> Self {
        let series = || Vec::with_capacity(rows);
        Recorder {
            time_s: series(),
            force_n: series(),
            key_m: series(),
            hammer_head_m: Vec::new(),
            bodies: instrument
                .bodies
                .iter()
                .map(|b| BodySeries { name: b.name.clone(), angle_rad: series(), rate_rad_per_s: series() })
                .collect(),
            zones: instrument
                .zones
                .iter()
                .map(|z| ZoneSeries {
                    name: z.name.clone(),
                    label: z.label.clone(),
                    normal_n: series(),
                    tangential_n: Vec::with_capacity(if z.friction_coefficient > 0.0 { rows } else { 0 }),
                    has_friction: z.friction_coefficient > 0.0,
                    contact: Vec::with_capacity(rows),
                })
                .collect(),
            has_hammer: instrument.roles.hammer.is_some(),
            pending: None,
        }
    }

    /// After every step, before [`Recorder::row`]: centres the last row's forces on its instant.
    pub fn step(&mut self, m: &dyn Mechanism) {
        let Some(before) = self.pending.take() else { return };
        // Forces belong to the middles of their steps: the mean, where the steps are equal.
        let share = before / (before + m.last_step());
        let mean = |series: &mut Vec<f64>, next: f64| {
            if let Some(last) = series.last_mut() {
                *last = (1.0 - share) * *last + share * next;
            }
        };
        mean(&mut self.force_n, m.drive_force());
        let contacts = m.contacts();
        for ((zone, contact), tangential) in self.zones.iter_mut().zip(contacts).zip(m.tangential_forces()) {
            let Some(contact) = contact else {
                // Nothing now, and nothing in the last row: nothing between.
                if zone.normal_n.last().is_some_and(|last| *last != 0.0) {
                    mean(&mut zone.normal_n, 0.0);
                }
                if zone.tangential_n.last().is_some_and(|last| *last != 0.0) {
                    mean(&mut zone.tangential_n, *tangential);
                }
                continue;
            };
            mean(&mut zone.normal_n, contact.force);
            if zone.has_friction {
                mean(&mut zone.tangential_n, *tangential);
            }
            // A contact that began with this step pushes in the last row too, and has its place from here.
            if let Some(place) = zone.contact.last_mut()
                && place[2..] == [0.0; 2]
            {
                *place = place_of(contact);
            }
        }
    }

    /// A row: key travel and hammer rise from rest, m.
    pub fn row(&mut self, time_s: f64, key_m: f64, hammer_m: f64, m: &dyn Mechanism) {
        self.pending = Some(m.last_step());
        self.time_s.push(time_s);
        self.force_n.push(m.drive_force());
        self.key_m.push(key_m);
        if self.has_hammer {
            self.hammer_head_m.push(hammer_m);
        }
        for ((body, angle), rate) in self.bodies.iter_mut().zip(m.angles()).zip(m.velocities()) {
            body.angle_rad.push(*angle);
            body.rate_rad_per_s.push(*rate);
        }
        let contacts = m.contacts();
        for ((zone, contact), tangential) in self.zones.iter_mut().zip(contacts).zip(m.tangential_forces()) {
            let (force, place) = contact.as_ref().map_or((0.0, [0.0; 4]), |c| (c.force, place_of(c)));
            zone.normal_n.push(force);
            zone.contact.push(place);
            if zone.has_friction {
                zone.tangential_n.push(*tangential);
            }
        }
    }
}

/// Contact point and normal, as a run keeps them.
fn place_of(contact: &Contact<f64>) -> [f32; 4] {
    let ([x, y], [nx, ny]) = (contact.point, contact.normal);
    [x as f32, y as f32, nx as f32, ny as f32]
}
