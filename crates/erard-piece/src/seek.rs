//! Which hand to try next.

use crate::touches::{FORCES_N, by_work};

/// A speed is right within this share of it: a fifth of a count of velocity.
pub(crate) const CLOSE: f64 = 5e-3;
/// Largest change of a hand from trial to trial: of the logarithm of its force, and of its beginning, s.
const MAX_STEPS: [f64; 2] = [0.7, 0.025];
/// Change of a hand's beginning that weighs as much as one of the logarithm of its force, s.
const WEIGHT_S: f64 = 0.05;

/// Number of hands without sound in a row after which the search ends.
const MAX_SILENT: u32 = 6;

/// Number of times that a speed is bracketed.
const MAX_BRACKETED: u32 = 7;

/// A hand to try: its force, N, and its lead before the written instant, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hand {
    pub force_n: f64,
    pub takes_s: f64,
}

/// Result of a trial.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome {
    pub tried: Hand,
    /// Impact: time after the hand's beginning, s, and hammer speed, m/s.
    pub struck: Option<[f64; 2]>,
    /// Lateness, s.
    pub late_s: f64,
    /// Whether the key is in this state whenever the hand begins: at home, or so long after its release.
    pub is_alike: bool,
}

/// The search from trial to trial.
pub(crate) struct Seek {
    wanted: f64,
    rise_s: f64,
    low: Option<[f64; 2]>,
    high: Option<[f64; 2]>,
    /// The derivatives of the speed's logarithm and the lateness over WEIGHT_S by the force's logarithm and the
    /// beginning over WEIGHT_S.
    slopes: [[f64; 2]; 2],
    last: Option<([f64; 2], [f64; 2])>,
    /// The last hand that sounded, and how many since did not.
    sounding: Option<Hand>,
    silent: u32,
    tried: u32,
}

impl Seek {
    pub(crate) fn new(wanted: f64, rise_s: f64) -> Self {
        let [less, more] = [wanted / 1.05, wanted * 1.05].map(|speed| by_work(speed, rise_s));
        let rate = (1.05_f64.ln() * 2.0 / (more.force_n / less.force_n).ln()).clamp(0.2, 5.0);
        let takes = (more.takes_s - less.takes_s) / (2.0 * 1.05_f64.ln()) * rate / WEIGHT_S;
        Seek {
            wanted,
            rise_s,
            low: None,
            high: None,
            slopes: [[rate, 0.0], [takes, -1.0]],
            last: None,
            sounding: None,
            silent: 0,
            tried: 0,
        }
    }

    /// The next hand; `None` where there is none left.
    pub(crate) fn next(&mut self, found: &Outcome) -> Option<Hand> {
        self.silent = if found.struck.is_some() { 0 } else { self.silent + 1 };
        if self.silent > MAX_SILENT {
            return None;
        }
        self.tried += 1;
        // A bracket that has not closed by now holds no answer: a pedal moves while the key is pressed, say.
        let is_bracketed = found.is_alike && self.tried <= MAX_BRACKETED;
        let next = if is_bracketed { self.between(found) } else { self.along(found) };
        let force_n = next.force_n.clamp(FORCES_N[0], FORCES_N[1]);
        let is_new =
            (force_n / found.tried.force_n - 1.0).abs() > 1e-6 || (next.takes_s - found.tried.takes_s).abs() > 1e-5;
        is_new.then_some(Hand { force_n, takes_s: next.takes_s })
    }

    /// From one state more force is more speed: the speed is bracketed, and the hand begins as long before as the last
    /// one took.
    fn between(&mut self, found: &Outcome) -> Hand {
        let Hand { force_n, takes_s } = found.tried;
        let [took_s, speed] = found.struck.unwrap_or([takes_s, 0.0]);
        if (speed / self.wanted).ln().abs() <= CLOSE {
            return Hand { force_n, takes_s: took_s };
        }
        if speed < self.wanted {
            self.low = Some([force_n, speed]);
            self.high = self.high.filter(|[force, _]| *force > force_n);
        } else {
            self.high = Some([force_n, speed]);
            self.low = self.low.filter(|[force, _]| *force < force_n);
        }
        let work = |speed: f64| by_work(speed, self.rise_s);
        let force_n = match (self.low, self.high) {
            (Some([a, va]), Some([b, vb])) if va > 0.0 => {
                let share = ((self.wanted / va).ln() / (vb / va).ln()).clamp(0.05, 0.95);
                a * (b / a).powf(share)
            }
            (Some([a, _]), Some([b, _])) => (a * b).sqrt(),
            _ if speed > 0.0 => {
                let by = work(self.wanted).force_n / work(speed).force_n;
                // A little past the speed, so that the bracket closes.
                force_n * by.clamp(0.3, 3.0) * if speed < self.wanted { 1.02 } else { 0.98 }
            }
            _ => 1.4 * force_n,
        };
        // A hand that is at its limit already takes as long again.
        let is_at_limit = (force_n.clamp(FORCES_N[0], FORCES_N[1]) / found.tried.force_n - 1.0).abs() < 1e-6;
        let takes_s = match speed > 0.0 {
            true if is_at_limit => took_s,
            true => took_s * work(self.wanted).takes_s / work(speed).takes_s,
            false => takes_s,
        };
        Hand { force_n, takes_s }
    }

    /// On a key that moves both matter to both: Broyden's method (Math. Comp. 19 (1965) 577), begun with the slopes
    /// that work has at home.
    fn along(&mut self, found: &Outcome) -> Hand {
        let Hand { force_n, takes_s } = found.tried;
        let Some([_, speed]) = found.struck else {
            // Back half the way to the last one that sounded; as long as none has, stronger and a little later.
            return match self.sounding {
                Some(one) => Hand { force_n: (one.force_n * force_n).sqrt(), takes_s: 0.5 * (one.takes_s + takes_s) },
                None => Hand { force_n: 1.3 * force_n, takes_s: takes_s - 2e-3 },
            };
        };
        self.sounding = Some(found.tried);
        let (x, r) = ([force_n.ln(), takes_s / WEIGHT_S], [(speed / self.wanted).ln(), found.late_s / WEIGHT_S]);
        if let Some((x0, r0)) = self.last {
            let dx = [x[0] - x0[0], x[1] - x0[1]];
            let length = dx[0] * dx[0] + dx[1] * dx[1];
            if length > 0.0 {
                for (row, (now, before)) in self.slopes.iter_mut().zip(r.iter().zip(r0)) {
                    let miss = (now - before - row[0] * dx[0] - row[1] * dx[1]) / length;
                    row[0] += miss * dx[0];
                    row[1] += miss * dx[1];
                }
            }
        }
        self.last = Some((x, r));
        let [[a, b], [c, d]] = self.slopes;
        let det = a * d - b * c;
        if det.abs() < 0.05 {
            // It has lost its way.
            let Seek { sounding, silent, tried, .. } = *self;
            *self = Seek { sounding, silent, tried, ..Seek::new(self.wanted, self.rise_s) };
            return Hand { force_n: force_n * (self.wanted / speed).powf(0.7), takes_s: takes_s + 0.7 * found.late_s };
        }
        let step = [(b * r[1] - d * r[0]) / det, (c * r[0] - a * r[1]) / det];
        let step =
            [step[0].clamp(-MAX_STEPS[0], MAX_STEPS[0]), (step[1] * WEIGHT_S).clamp(-MAX_STEPS[1], MAX_STEPS[1])];
        Hand { force_n: force_n * step[0].exp(), takes_s: takes_s + step[1] }
    }
}
