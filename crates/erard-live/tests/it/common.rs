//! Presses whose hammer is known, as a sensor at the key sees them.

use erard::{Input, Instrument};
use erard_live::finger::{FINGER, Leg, place};
use erard_live::stream::{Of, Sample, SensorUnit};
use erard_live::{Event, Live, Options, SensorKind};

pub use crate::press::{GRAND, Press};

impl Press {
    /// A finger of 100 g that follows a path from the key's rest: legs of least jerk, each a duration, s, and a depth,
    /// m.
    pub fn along(instrument: &Instrument, path: &[Leg]) -> Self {
        let lasts_s = path.iter().map(|[s, _]| s).sum::<f64>() + 0.3;
        Press::played(instrument, lasts_s, (0.0, 0.0), |t| {
            let [position_m, velocity_m_per_s] = place(0.0, path, t);
            FINGER.input(&Input::Motion { position_m, velocity_m_per_s }).unwrap()
        })
    }

    /// Where the hammer's head is at an instant, m above its rest.
    pub fn head(&self, t: f64) -> f64 {
        self.of(&self.head_m, t)
    }

    /// How long it lasts, s.
    pub fn lasts_s(&self) -> f64 {
        self.h * (self.key_m.len() - 1) as f64
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
    let quantity = if sensor == SensorKind::Force { SensorUnit::Newtons } else { SensorUnit::Millimetres };
    Options { sensor, quantity, sensor_at_m: None, travel_m: None, ahead, moved: None, threads: 1 }
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
        Event::On { time_s, hammer_speed_m_per_s, .. } => Some([*time_s, *hammer_speed_m_per_s]),
        _ => None,
    };
    events.iter().filter_map(on).collect()
}

/// Note-offs: when, s.
pub fn offs(events: &[Event]) -> Vec<f64> {
    events.iter().filter_map(|event| if let Event::Off { time_s, .. } = event { Some(*time_s) } else { None }).collect()
}
