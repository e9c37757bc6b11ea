//! Presses whose hammer is known, as a sensor at the key sees them.

use std::sync::LazyLock;

use erard::level::{Kind, Reference};
use erard::stroke::Touch;
use erard::{Action, Instrument, Settings};
use erard_live::stream::{Of, Quantity, Sample};
use erard_live::{Event, Live, Options, SensorKind};

/// The built-in grand.
pub static GRAND: LazyLock<Instrument> = LazyLock::new(|| Instrument::builtin("concert-grand").unwrap());

/// A press: the key's way at every step of 50 us, and the impacts.
pub struct Press {
    pub key_m: Vec<f64>,
    pub impacts: Vec<[f64; 2]>,
    h: f64,
}

impl Press {
    /// A hand that gives the hammer a speed, m/s, holds the key and leaves it at half a second.
    pub fn to(speed_m_per_s: f64) -> Self {
        let mut reference = Reference::new(&GRAND, &mut |_| true).unwrap();
        let kind = Kind { touch: Touch::Pressed, mass_kg: 0.2 };
        let stroke = reference.solve(kind, speed_m_per_s, &mut |_| true).unwrap().whole();
        let mut action = Action::new(&GRAND).unwrap();
        let Settings { step: h, theta, .. } = *action.settings();
        let (mut key_m, mut impacts) = (vec![0.0], vec![]);
        for n in 0..(0.9 / h) as u32 {
            let reading = action.step(stroke.hand.input(&stroke.input((f64::from(n) + theta) * h)).unwrap());
            key_m.push(reading.key_m);
            impacts.extend(reading.impact.map(|impact| [impact.time_s, impact.hammer_speed_m_per_s]));
        }
        Press { key_m, impacts, h }
    }

    /// Where the key is at an instant, m.
    pub fn at(&self, t: f64) -> f64 {
        let last = self.key_m.len() - 1;
        let place = (t / self.h).clamp(0.0, last as f64);
        let i = (place as usize).min(last - 1);
        self.key_m[i] + (place - i as f64) * (self.key_m[i + 1] - self.key_m[i])
    }

    /// As a sensor sends it: `rate` samples a second, the first `from_s` after the press began, rounded to steps, mm.
    pub fn sensed(&self, key: usize, begins_s: f64, rate: f64, phase_s: f64, step_mm: f64) -> Vec<Sample> {
        let count = (0.9 * rate) as u32;
        let sample = |k: u32| {
            let t = f64::from(k) / rate + phase_s;
            let mm = 1e3 * self.at(t);
            let value = if step_mm > 0.0 { (mm / step_mm).round() * step_mm } else { mm };
            Sample { time_s: begins_s + t, of: Of::Key(key), value }
        };
        (0..count).map(sample).collect()
    }
}

/// Usual options.
pub fn options(sensor: SensorKind, ahead: bool) -> Options {
    let quantity = if sensor == SensorKind::Force { Quantity::Newtons } else { Quantity::Millimetres };
    Options { sensor, quantity, sensor_at_m: None, travel_m: None, ahead, threads: 1 }
}

/// One key, the built-in grand's, as key 1.
pub fn one_key(sensor: SensorKind, ahead: bool) -> Live {
    Live::new(std::slice::from_ref(&*GRAND), None, options(sensor, ahead), &mut |_| true).unwrap()
}

/// All events of samples, and of letting go at the end.
pub fn played(live: &mut Live, samples: &[Sample]) -> Vec<Event> {
    let mut events = Vec::new();
    for sample in samples {
        live.take(sample, &mut |event| events.push(event));
    }
    live.let_go(&mut |event| events.push(event));
    events
}

/// Note-ons: when, s, and the hammer's speed, m/s.
pub fn ons(events: &[Event]) -> Vec<[f64; 2]> {
    let on = |event: &Event| match event {
        Event::On { time_s, hammer_m_per_s, .. } => Some([*time_s, *hammer_m_per_s]),
        _ => None,
    };
    events.iter().filter_map(on).collect()
}

/// Note-offs: when, s.
pub fn offs(events: &[Event]) -> Vec<f64> {
    events.iter().filter_map(|event| if let Event::Off { time_s, .. } = event { Some(*time_s) } else { None }).collect()
}
