//! Presses of the built-in grand whose hammer is known.

use std::sync::LazyLock;

use erard::level::{HandKind, Reference};
use erard::stroke::Touch;
use erard::{Action, Instrument, Settings};

/// The built-in grand.
pub static GRAND: LazyLock<Instrument> = LazyLock::new(|| Instrument::builtin("concert-grand").unwrap());

/// A press: the key's way at every step of 50 us, and the impacts.
pub struct Press {
    pub key_m: Vec<f64>,
    pub impacts: Vec<[f64; 2]>,
    /// Length of a step, s.
    pub h: f64,
}

impl Press {
    /// A hand that gives the hammer a speed, m/s, holds the key and leaves it at half a second.
    pub fn to(speed_m_per_s: f64) -> Self {
        Press::on(&GRAND, speed_m_per_s)
    }

    /// The same on another action.
    pub fn on(instrument: &Instrument, speed_m_per_s: f64) -> Self {
        Press::by(instrument, Touch::Pressed, speed_m_per_s)
    }

    /// The same by a touch.
    pub fn by(instrument: &Instrument, touch: Touch, speed_m_per_s: f64) -> Self {
        let mut reference = Reference::new(instrument, &mut |_| true).unwrap();
        let kind = HandKind::new(touch, 0.2);
        let stroke = reference.solve(kind, speed_m_per_s, &mut |_| true).unwrap().whole();
        let mut action = Action::new(instrument).unwrap();
        let Settings { step: h, theta, .. } = *action.settings();
        let (mut key_m, mut impacts) = (vec![0.0], vec![]);
        action.place_hand(stroke.hand.start_m, stroke.hand.start_m_per_s);
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
}
