//! Forces and times learnt from a key's strokes: the hammer speed that a force gives from rest, and the time that it
//! takes; and the time from the release of the key until its damper is down.

/// Rise times of the muscle's force, s, the usual one first. A hand that has little time, or must be louder than the
/// usual one can, is quicker. The shorter ones are estimates.
pub(crate) const RISES_S: [f64; 3] = [erard::stroke::RISE_S, 0.020, 0.008];
/// The force of a hand, N, from 0.2 to 100: [`erard::level::FORCES_N`].
pub(crate) const FORCES_N: [f64; 2] = erard::level::FORCES_N;
/// Difference in the logarithm of speed below which only the last of two touches is remembered: a key that has been
/// played does not rest exactly as before.
const ALIKE: f64 = 1e-2;

/// A hand for a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Guess {
    pub force_n: f64,
    /// From the hand's beginning to the impact, s.
    pub takes_s: f64,
    /// Whether it rests on a touch of this key.
    pub is_known: bool,
}

/// The hand that work and momentum ask for: that of [`erard::level`], for a key as heavy as 0.3 kg at its front whose
/// hammer turns 5.5 times as fast. How long it takes is a fit to a grand's middle. It moves the number of trials only.
pub(crate) fn by_work(speed_m_per_s: f64, rise_s: f64) -> Guess {
    let key_m_per_s = speed_m_per_s / 5.5;
    let force_n = 0.5 + 0.5 * key_m_per_s * key_m_per_s / (2.0 * 8e-3);
    let takes_s = 0.093 * speed_m_per_s.max(0.2).powf(-0.55) - 0.4 * (RISES_S[0] - rise_s);
    Guess { force_n: force_n.clamp(FORCES_N[0], FORCES_N[1]), takes_s: takes_s.max(0.02), is_known: false }
}

/// Speed, m/s, and by which factors force and time differ from [`by_work`].
#[derive(Debug, Clone, Copy)]
struct Touch {
    log_speed: f64,
    force: f64,
    takes: f64,
}

impl Touch {
    fn of(rise: usize, force_n: f64, takes_s: f64, speed_m_per_s: f64) -> Self {
        let work = by_work(speed_m_per_s, RISES_S[rise]);
        Touch { log_speed: speed_m_per_s.ln(), force: force_n / work.force_n, takes: takes_s / work.takes_s }
    }
}

/// Touches known for one key.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    /// By rise time, in the order of speed.
    known: [Vec<Touch>; RISES_S.len()],
    /// The last stroke on a key that was still on its way.
    moving: [Option<Touch>; RISES_S.len()],
    /// Ways of leaving, s, with how long the damper then takes to be down, s, and how fast the key comes, m/s.
    ways: Vec<[f64; 3]>,
}

impl Touches {
    /// The hand for a speed, from known touches.
    pub(crate) fn guess(&self, rise: usize, speed_m_per_s: f64) -> Guess {
        let work = by_work(speed_m_per_s, RISES_S[rise]);
        let (known, at) = (&self.known[rise], speed_m_per_s.ln());
        let above = known.partition_point(|touch| touch.log_speed < at);
        let [force, takes] = match (above.checked_sub(1).map(|i| known[i]), known.get(above).copied()) {
            (Some(a), Some(b)) => {
                let share = (at - a.log_speed) / (b.log_speed - a.log_speed);
                [a.force + share * (b.force - a.force), a.takes + share * (b.takes - a.takes)]
            }
            (Some(one), None) | (None, Some(one)) => [one.force, one.takes],
            // A quicker hand is about as strong.
            (None, None) if rise > 0 => {
                let usual = self.guess(0, speed_m_per_s);
                let ratio = usual.force_n / by_work(speed_m_per_s, RISES_S[0]).force_n;
                return Guess { force_n: (ratio * work.force_n).clamp(FORCES_N[0], FORCES_N[1]), ..work };
            }
            (None, None) => return work,
        };
        let force_n = (force * work.force_n).clamp(FORCES_N[0], FORCES_N[1]);
        Guess { force_n, takes_s: takes * work.takes_s, is_known: true }
    }

    /// The hand for a speed on a key that is still on its way: as the last one was.
    pub(crate) fn guess_moving(&self, rise: usize, speed_m_per_s: f64) -> Guess {
        let work = by_work(speed_m_per_s, RISES_S[rise]);
        match self.moving[rise] {
            Some(Touch { force, takes, .. }) => Guess {
                force_n: (force * work.force_n).clamp(FORCES_N[0], FORCES_N[1]),
                takes_s: takes * work.takes_s,
                is_known: true,
            },
            None => self.guess(rise, speed_m_per_s),
        }
    }

    /// Remembers the result of a hand on a key that was still moving.
    pub(crate) fn learn_moving(&mut self, rise: usize, force_n: f64, takes_s: f64, speed_m_per_s: f64) {
        self.moving[rise] = Some(Touch::of(rise, force_n, takes_s, speed_m_per_s));
    }

    /// Remembers the result of a hand from rest.
    pub(crate) fn learn(&mut self, rise: usize, force_n: f64, takes_s: f64, speed_m_per_s: f64) {
        let touch = Touch::of(rise, force_n, takes_s, speed_m_per_s);
        let known = &mut self.known[rise];
        known.retain(|other| (other.log_speed - touch.log_speed).abs() >= ALIKE);
        let at = known.partition_point(|other| other.log_speed < touch.log_speed);
        known.insert(at, touch);
    }

    /// Time until the damper is down, s, from the beginning of a release of this duration, s.
    pub(crate) fn lag_s(&self, within_s: f64) -> f64 {
        let near = |way: &&[f64; 3]| (way[0] / within_s).ln().abs();
        match self.ways.iter().min_by(|a, b| near(a).total_cmp(&near(b))) {
            Some(way) if near(&way) < 0.3 => way[1] + 0.5 * (within_s - way[0]),
            _ => 0.027 + 0.6 * within_s,
        }
    }

    /// Whether a hand has left the key so that it came up about so fast, m/s.
    pub(crate) fn knows_way(&self, speed_m_per_s: f64) -> bool {
        self.ways.iter().any(|way| (way[2] / speed_m_per_s).ln().abs() < 0.1)
    }

    /// Remembers the duration of a release, and the key's speed on its way up.
    pub(crate) fn learn_way(&mut self, within_s: f64, lag_s: f64, speed_m_per_s: f64) {
        match self.ways.iter_mut().find(|way| (way[0] / within_s).ln().abs() < 0.02) {
            Some(way) => *way = [within_s, lag_s, speed_m_per_s],
            None => self.ways.push([within_s, lag_s, speed_m_per_s]),
        }
    }

    /// Within what time a hand must leave so that the key comes up so fast, s: the known way that comes nearest, or a
    /// guess.
    pub(crate) fn way_of(&self, speed_m_per_s: f64) -> f64 {
        let near = |way: &&[f64; 3]| (way[2] / speed_m_per_s).ln().abs();
        let known = self.ways.iter().filter(|way| way[2] > 0.0).min_by(|a, b| near(a).total_cmp(&near(b)));
        match known {
            Some(way) if near(&way) < 0.1 => way[0],
            _ => (0.030 * (0.25 / speed_m_per_s).powi(2)).clamp(2e-3, 0.5),
        }
    }
}
