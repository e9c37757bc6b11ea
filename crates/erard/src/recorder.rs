//! Writes down a run while it goes on.

use crate::instrument::Instrument;
use crate::mechanism::Mechanism;
use crate::run::{BodySeries, ZoneSeries};

/// Series under construction.
#[derive(Debug)]
pub(crate) struct Recorder {
    pub time_s: Vec<f64>,
    pub force_n: Vec<f64>,
    pub key_m: Vec<f64>,
    pub hammer_head_m: Vec<f64>,
    pub bodies: Vec<BodySeries>,
    pub zones: Vec<ZoneSeries>,
    has_hammer: bool,
    /// The last row's forces are those of a step of this length, s, and still wait for those of the step after it.
    pending: Option<f64>,
}

impl Recorder {
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
        for (z, zone) in self.zones.iter_mut().enumerate() {
            mean(&mut zone.normal_n, m.normal_force(z));
            if zone.has_friction {
                mean(&mut zone.tangential_n, m.tangential_force(z));
            }
            // A contact that began with this step pushes in the last row too, and has its place from here.
            if let Some(place) = zone.contact.last_mut()
                && place[2..] == [0.0; 2]
            {
                *place = m.contact(z);
            }
        }
    }

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
        for (z, zone) in self.zones.iter_mut().enumerate() {
            zone.normal_n.push(m.normal_force(z));
            if zone.has_friction {
                zone.tangential_n.push(m.tangential_force(z));
            }
            zone.contact.push(m.contact(z));
        }
    }
}
