//! Records a run.

use moreau::Contact;

use crate::instrument::Instrument;
use crate::mechanism::{Mechanism, Readout, Stepping};
use crate::strings::{ShapeProbe, Strings};

/// Recorded motion of modal strings.
#[derive(Debug, Clone, Default)]
pub struct StringSeries {
    /// Displacement under the hammer from a straight line, m, away from the hammer; for several strings their mean. It
    /// includes the displacement by a damper's weight.
    pub displacement_m: Vec<f64>,
    /// Force of all of them on the bridge, N, positive in the direction in which the hammer pushes.
    pub bridge_n: Vec<f64>,
    /// Places along the middle one of them, m from the striking point, away from the nearer end.
    pub places_m: Vec<f64>,
    /// Its displacement at these places, m, row after row.
    pub shape_m: Vec<f32>,
    /// Lift of the pedal's rail, m; empty where there is none.
    pub pedal_m: Vec<f64>,
}

/// One body's motion.
#[derive(Debug, Clone, Default)]
pub struct BodySeries {
    /// Body name.
    pub name: String,
    /// Absolute angle of the body's frame, rad, counter-clockwise.
    pub angle_rad: Vec<f64>,
    /// Absolute angular velocity, rad/s.
    pub rate_rad_per_s: Vec<f64>,
}

/// One zone's forces.
#[derive(Debug, Clone, Default)]
pub struct ZoneSeries {
    /// Zone name.
    pub name: String,
    /// Human label.
    pub label: String,
    /// Normal force, N, never negative.
    pub normal_n: Vec<f64>,
    /// Coulomb force on side A along the tangent (normal turned clockwise by 90 degrees), N; empty where the zone has
    /// no friction.
    pub tangential_n: Vec<f64>,
    /// Whether the zone has Coulomb friction.
    pub has_friction: bool,
    /// Contact point in the world and the outward unit normal of side B, `[x, y, nx, ny]`, m; valid where `normal_n >
    /// 0`.
    pub contact: Vec<[f32; 4]>,
}

/// A recorded run. Units and signs as in [`crate::run::Run`].
#[derive(Debug)]
pub struct Recorded {
    /// Instants of the rows, s.
    pub time_s: Vec<f64>,
    /// Force of the drive, N.
    pub force_n: Vec<f64>,
    /// Travel of the key front, m.
    pub key_m: Vec<f64>,
    /// Rise of the hammer's strike point, m; empty without a hammer.
    pub hammer_rise_m: Vec<f64>,
    /// Its speed, m/s; empty without a hammer.
    pub hammer_rise_m_per_s: Vec<f64>,
    /// The bodies, in the instrument's order.
    pub bodies: Vec<BodySeries>,
    /// The zones, in the instrument's order.
    pub zones: Vec<ZoneSeries>,
    /// The strings, where they yield.
    pub strings: Option<StringSeries>,
}

/// An observer that records an action's series. It needs every step, and every instant that makes a row.
///
/// Memory for all rows is allocated at once as zeros, which the operating system provides only where they are
/// overwritten: a zone that is never touched costs neither time nor memory.
#[derive(Debug)]
pub struct Recorder {
    recorded: Recorded,
    rows: usize,
    has_hammer: bool,
    /// The last row's forces are those of a step of this length, s, and still wait for those of the step after it.
    pending: Option<f64>,
    /// The probe of the string's shape.
    shape: Option<ShapeProbe>,
}

impl Recorder {
    /// Makes a recorder for at most this many rows of an instrument with this mechanism.
    pub(crate) fn new(instrument: &Instrument, rows: usize, m: &mut dyn Mechanism) -> Self {
        m.configure(Stepping { keeps_contacts: true, ..*m.readout().stepping });
        let series = || vec![0.0; rows];
        let has_hammer = instrument.roles.hammer.is_some();
        let recorded = Recorded {
            time_s: series(),
            force_n: series(),
            key_m: series(),
            hammer_rise_m: if has_hammer { series() } else { Vec::new() },
            hammer_rise_m_per_s: if has_hammer { series() } else { Vec::new() },
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
                    tangential_n: if z.friction_coefficient > 0.0 { series() } else { Vec::new() },
                    has_friction: z.friction_coefficient > 0.0,
                    contact: vec![[0.0; 4]; rows],
                })
                .collect(),
            strings: Strings::under(m).map(|strings| {
                let places_m = strings.probe_places_m();
                let shape_m = vec![0.0; rows * places_m.len()];
                let pedal_m = if strings.pedal_m().is_some() { series() } else { Vec::new() };
                StringSeries { displacement_m: series(), bridge_n: series(), places_m, shape_m, pedal_m }
            }),
        };
        let shape = Strings::under(m).map(Strings::shape_probe);
        Recorder { recorded, rows: 0, has_hammer, pending: None, shape }
    }

    /// After every step, before [`Recorder::row`]: centres the last row's forces on its instant.
    pub(crate) fn step(&mut self, now: &Readout<'_>) {
        let Some(before) = self.pending.take() else { return };
        // Forces belong to the middles of their steps: the mean, where the steps are equal.
        let share = before / (before + now.last_step_s);
        let mean = |last: &mut f64, next: f64| *last = (1.0 - share) * *last + share * next;
        let row = self.rows - 1;
        let force = &mut self.recorded.force_n[row];
        if row == 0 && *force == 0.0 {
            // Nobody pushed before the run: it begins with the force that begins, not with the half of it. Else a run's
            // own force, played again, would not be the run.
            *force = now.output.drive_n;
        } else {
            mean(force, now.output.drive_n);
        }
        let acting = now.contacts.iter().zip(now.tangential_forces);
        for (zone, (contact, tangential)) in self.recorded.zones.iter_mut().zip(acting) {
            let Some(contact) = contact else {
                // Nothing now, and nothing in the last row: nothing between.
                if zone.normal_n[row] != 0.0 {
                    mean(&mut zone.normal_n[row], 0.0);
                }
                if zone.has_friction && zone.tangential_n[row] != 0.0 {
                    mean(&mut zone.tangential_n[row], *tangential);
                }
                continue;
            };
            mean(&mut zone.normal_n[row], contact.force);
            if zone.has_friction {
                mean(&mut zone.tangential_n[row], *tangential);
            }
            // A contact that began with this step pushes in the last row too, and has its place from here.
            let place = &mut zone.contact[row];
            if place[2..] == [0.0; 2] {
                *place = place_of(contact);
            }
        }
    }

    /// Replaces [`Recorder::step`] where the last two steps changed nothing: their forces are equal and so are their
    /// own mean.
    pub(crate) fn unchanged(&mut self) {
        self.pending = None;
    }

    /// A row: key travel and hammer rise from rest, m.
    ///
    /// # Panics
    /// If there are more rows than the recorder was made for.
    pub(crate) fn row(&mut self, time_s: f64, key_m: f64, hammer_rise_m: f64, now: &Readout<'_>) {
        self.pending = Some(now.last_step_s);
        let row = self.rows;
        self.rows += 1;
        let to = &mut self.recorded;
        to.time_s[row] = time_s;
        to.force_n[row] = now.output.drive_n;
        to.key_m[row] = key_m;
        if self.has_hammer {
            to.hammer_rise_m[row] = hammer_rise_m;
            to.hammer_rise_m_per_s[row] = now.output.point_m_per_s[1];
        }
        if let (Some(series), Some(strings)) = (&mut to.strings, Strings::read(now)) {
            series.displacement_m[row] = strings.displacement_m();
            series.bridge_n[row] = strings.bridge_n();
            if let (Some(lift), Some(lift_m)) = (series.pedal_m.get_mut(row), strings.pedal_m()) {
                *lift = lift_m;
            }
            if let Some(shape) = &self.shape {
                let count = series.places_m.len();
                shape.read(strings, &mut series.shape_m[row * count..(row + 1) * count]);
            }
        }
        for ((body, angle), rate) in to.bodies.iter_mut().zip(now.angles).zip(now.velocities) {
            body.angle_rad[row] = *angle;
            body.rate_rad_per_s[row] = *rate;
        }
        for ((zone, contact), tangential) in to.zones.iter_mut().zip(now.contacts).zip(now.tangential_forces) {
            if let Some(contact) = contact {
                zone.normal_n[row] = contact.force;
                zone.contact[row] = place_of(contact);
            }
            if zone.has_friction && *tangential != 0.0 {
                zone.tangential_n[row] = *tangential;
            }
        }
    }

    /// The recorded series.
    pub(crate) fn finish(self) -> Recorded {
        let Recorder { mut recorded, rows, .. } = self;
        let Recorded { time_s, force_n, key_m, hammer_rise_m, hammer_rise_m_per_s, bodies, zones, strings } =
            &mut recorded;
        if let Some(strings) = strings {
            strings.shape_m.truncate(rows * strings.places_m.len());
        }
        let strings = strings.iter_mut().flat_map(|s| [&mut s.displacement_m, &mut s.bridge_n, &mut s.pedal_m]);
        for column in [time_s, force_n, key_m, hammer_rise_m, hammer_rise_m_per_s].into_iter().chain(strings) {
            column.truncate(rows);
        }
        for body in bodies {
            body.angle_rad.truncate(rows);
            body.rate_rad_per_s.truncate(rows);
        }
        for zone in zones {
            zone.normal_n.truncate(rows);
            zone.tangential_n.truncate(rows);
            zone.contact.truncate(rows);
        }
        recorded
    }
}

/// Contact point and normal, as a run keeps them.
fn place_of(contact: &Contact<f64>) -> [f32; 4] {
    let ([x, y], [nx, ny]) = (contact.point, contact.normal);
    [x as f32, y as f32, nx as f32, ny as f32]
}
