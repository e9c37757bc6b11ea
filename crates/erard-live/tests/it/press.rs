//! Presses of the built-in grand whose hammer is known.

use std::sync::LazyLock;

use erard::level::{HandKind, Reference};
use erard::stroke::Touch;
use erard::{Action, Input, Instrument, Settings};

/// The built-in grand.
pub static GRAND: LazyLock<Instrument> = LazyLock::new(|| Instrument::builtin("concert-grand").unwrap());

/// A press: the key's way at every step of 50 us, and the impacts.
pub struct Press {
    pub key_m: Vec<f64>,
    /// Way of the hammer's head on its arc, by the angle of its shank. The example that shares this file does not look
    /// at it.
    #[allow(dead_code)]
    pub head_m: Vec<f64>,
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
        let start = (stroke.hand.start_m, stroke.hand.start_m_per_s);
        Press::played(instrument, 0.9, start, |t| stroke.hand.input(&stroke.input(t)).unwrap())
    }

    /// Played by inputs, from a hand's place, m, and speed, m/s.
    pub fn played(instrument: &Instrument, lasts_s: f64, start: (f64, f64), input: impl Fn(f64) -> Input) -> Self {
        let mut action = Action::new(instrument).unwrap();
        let Settings { step: h, theta, .. } = *action.settings();
        let (mut key_m, mut head_m, mut impacts) = (vec![0.0], vec![0.0], vec![]);
        action.place_hand(start.0, start.1);
        // The shank turns the head about its pin.
        let shank = instrument.bodies.iter().position(|body| body.name == "shank").unwrap();
        let (hammer, strikes) = erard::assembly::probes(instrument).point.unwrap();
        let [head, pin] =
            [(hammer, strikes), (shank, [0.0; 2])].map(|(body, at)| action.point(Some(body), at).unwrap());
        let (radius_m, rest) = ((head[0] - pin[0]).hypot(head[1] - pin[1]), action.angles()[shank]);
        for n in 0..(lasts_s / h) as u32 {
            let reading = action.step(input((f64::from(n) + theta) * h));
            key_m.push(reading.key_m);
            head_m.push(radius_m * (action.angles()[shank] - rest).abs());
            impacts.extend(reading.impact.map(|impact| [impact.time_s, impact.hammer_speed_m_per_s]));
        }
        Press { key_m, head_m, impacts, h }
    }

    /// Where the key is at an instant, m.
    pub fn at(&self, t: f64) -> f64 {
        self.of(&self.key_m, t)
    }

    /// One of its ways at an instant, m.
    pub fn of(&self, all: &[f64], t: f64) -> f64 {
        let last = all.len() - 1;
        let place = (t / self.h).clamp(0.0, last as f64);
        let i = (place as usize).min(last - 1);
        all[i] + (place - i as f64) * (all[i + 1] - all[i])
    }
}
