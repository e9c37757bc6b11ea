//! The table from the time between two contacts to the hammer's speed: a simulated action is pressed once, by three
//! touches.

use erard::damper::{DamperError, USUAL_HEIGHT_M, damper_height_m};
use erard::instrument::Instrument;
use erard::player::{ActionError, HandError};
use erard::stroke::HandStroke;
use erard::{Action, Input, Progress, Settings, Snapshot};

use crate::contacts::{COUNTS_PER_E, ContactFault, ContactLaw, MAX_CONTACTS, MAX_POINTS, Point, SpeedTable};
use crate::find::dip_m;
use crate::finger::{FINGER, Leg, place};
use crate::limits::MAX_HAMMER_M_PER_S;

/// The key of a keyboard that is pressed, a middle C.
pub const PRESSED_KEY: usize = 40;
/// Names of the touches: a hand that rests on the key presses it; a hand arrives with a speed; a finger presses again a
/// key that it has let up half-way.
pub const TOUCHES: [&str; 3] = ["pressed", "struck", "re-struck"];
/// Mass of the hand, kg.
const HAND_KG: f64 = 0.2;
/// Its forces, N, and speeds of arrival, m/s, in ratios of [`RATIO`].
const FORCES_N: [f64; 2] = [0.7, 60.0];
const ARRIVALS_M_PER_S: [f64; 2] = [0.05, 3.5];
const RATIO: f64 = 1.12;
/// A re-strike's first stroke and its way up, s; depths from which it presses again, m, and times for the way down, s.
const FIRST_S: [f64; 4] = [0.08, 0.25, 0.15, 0.1];
const HALF_WAY_M: [f64; 6] = [0.0, 1e-3, 2e-3, 3e-3, 4e-3, 5e-3];
const AGAIN_S: [f64; 2] = [0.012, 0.25];
/// Depth to which it presses, m beyond the dip.
const BEYOND_M: f64 = 0.5e-3;
/// A press that has not reached the bottom after this time does not, s.
const PATIENCE_S: f64 = 0.4;
/// A key this near to its dip has reached it, m.
const BOTTOM_M: f64 = 0.3e-3;
/// A key must come up so far above a contact to open it, m.
const OPENS_M: f64 = 0.3e-3;
/// Number of points of a table.
const POINTS: usize = MAX_POINTS;
/// Distance between depths that are compared, m; the upper contact's smallest depth and the lower one's distance from
/// the bottom, m.
const COMPARED_M: f64 = 0.5e-3;
const LEAST_M: f64 = 1e-3;
const ABOVE_M: f64 = 1e-3;

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContactTableError {
    /// The action cannot be assembled.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// Where the key sets its damper down cannot be found.
    #[error(transparent)]
    Damper(#[from] DamperError),
    /// A bug: a hand of constant numbers.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// The contacts' numbers.
    #[error(transparent)]
    Contacts(#[from] ContactFault),
    /// The key does not pass both contacts on its way to the string.
    #[error(
        "contacts at {upper_mm} and {lower_mm} mm: too few strokes pass both; expected depths within the key's dip, {dip_mm:.1} \
         mm"
    )]
    Beyond {
        /// Depth of the upper contact, mm.
        upper_mm: f64,
        /// Depth of the lower contact, mm.
        lower_mm: f64,
        /// Dip, mm.
        dip_mm: f64,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// A press: the key's way, and the impact.
struct Press {
    touch: usize,
    /// Depth from which the key was pressed, m.
    from_m: f64,
    /// Travel of the key's front at every step, m.
    key_m: Vec<f64>,
    /// Instant, s after the first of them, and hammer speed, m/s.
    impact: [f64; 2],
}

/// Presses of one simulated action, by three touches, from its softest to its loudest sounds.
pub struct Presses {
    all: Vec<Press>,
    h: f64,
    /// Dip, m.
    pub dip_m: f64,
    /// Travel at which the key sets its damper down, m.
    pub damper_m: f64,
}

impl Presses {
    /// Presses an instrument's key. `progress` receives the share that is done, and ends the work by returning false.
    ///
    /// # Errors
    /// [`ContactTableError`].
    pub fn of(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Self, ContactTableError> {
        let silent = instrument.with_rigid_string();
        let damper_m = damper_height_m(instrument)?.unwrap_or(USUAL_HEIGHT_M);
        let (mut action, dip_m) = (Action::with(&silent, Settings::new(silent.usual_step_s()))?, dip_m(&silent)?);
        let rest = action.save();
        let mut presses = Presses { all: Vec::new(), h: action.settings().step, dip_m, damper_m };
        let (forces, arrivals, again) = (ratios(FORCES_N), ratios(ARRIVALS_M_PER_S), ratios(AGAIN_S));
        let whole = forces.len() + arrivals.len() + HALF_WAY_M.len() * again.len();
        let mut done = 0;
        let mut goes_on = || {
            done += 1;
            if progress(done as f64 / whole as f64) { Ok(()) } else { Err(ContactTableError::Interrupted) }
        };
        let hands = [(0, forces), (1, arrivals)];
        for (touch, loudness) in hands.iter().flat_map(|(touch, all)| all.iter().map(move |one| (*touch, *one))) {
            goes_on()?;
            let stroke = [HandStroke::pressed, HandStroke::struck][touch](HAND_KG, loudness);
            let hand = stroke.hand;
            hand.check()?;
            presses.add(&mut action, (&rest, touch, 0.0), (hand.start_m, hand.start_m_per_s), &|t| {
                hand.input(&stroke.input(t))
            })?;
        }
        let bottom_m = dip_m + BEYOND_M;
        for up_m in HALF_WAY_M {
            let [down_s, holds_s, up_s, waits_s] = FIRST_S;
            let first = [[down_s, bottom_m], [holds_s, bottom_m], [up_s, up_m], [waits_s, up_m]];
            restore(&mut action, &rest);
            action.place_hand(0.0, 0.0);
            let Settings { step: h, theta, .. } = *action.settings();
            let steps = (first.iter().map(|[s, _]| s).sum::<f64>() / h) as u32;
            for n in 0..steps {
                action.step(finger(0.0, &first, (f64::from(n) + theta) * h)?);
            }
            let (half_way, hand) = (action.save(), action.reading());
            for &takes_s in &again {
                goes_on()?;
                let path = [[takes_s, bottom_m], [1.0, bottom_m]];
                let from = (&half_way, 2, hand.key_m);
                presses.add(&mut action, from, (hand.hand_m, hand.hand_m_per_s), &|t| finger(up_m, &path, t))?;
            }
        }
        Ok(presses)
    }

    /// Presses the key from a state, by a hand at a place, m, with a speed, m/s; keeps what sounds.
    fn add(
        &mut self,
        action: &mut Action,
        (state, touch, from_m): (&Snapshot, usize, f64),
        (hand_m, hand_m_per_s): (f64, f64),
        input: &dyn Fn(f64) -> Result<Input, HandError>,
    ) -> Result<(), ContactTableError> {
        restore(action, state);
        action.place_hand(hand_m, hand_m_per_s);
        let (begins_s, Settings { step: h, theta, .. }) = (action.time_s(), *action.settings());
        let (mut key_m, mut impact) = (vec![from_m], None);
        for n in 0..(PATIENCE_S / h) as u32 {
            let reading = action.step(input((f64::from(n) + theta) * h)?);
            key_m.push(reading.key_m);
            impact = impact.or(reading.impact.map(|hit| [hit.time_s - begins_s, hit.hammer_speed_m_per_s]));
            if reading.key_m > self.dip_m - BOTTOM_M && impact.is_some() {
                break;
            }
        }
        if let Some(impact) = impact {
            self.all.push(Press { touch, from_m, key_m, impact });
        }
        Ok(())
    }

    /// The table between contacts at two depths, m, the upper one first.
    ///
    /// # Errors
    /// [`ContactTableError::Beyond`].
    pub fn table(&self, upper_m: f64, lower_m: f64) -> Result<SpeedTable, ContactTableError> {
        let beyond =
            || ContactTableError::Beyond { upper_mm: 1e3 * upper_m, lower_mm: 1e3 * lower_m, dip_mm: 1e3 * self.dip_m };
        let curves: Vec<Curve> = (0..TOUCHES.len()).filter_map(|touch| self.curve(touch, upper_m, lower_m)).collect();
        // Where two touches sound: the second ends.
        let mut ends = [0, 1].map(|end| curves.iter().map(|one| one.ends()[end]).collect::<Vec<f64>>());
        ends.iter_mut().for_each(|all| all.sort_by(f64::total_cmp));
        let [Some(&from), Some(&to)] = [ends[0].get(1), ends[1].iter().nth_back(1).as_ref().copied()] else {
            return Err(beyond());
        };
        if to <= from {
            return Err(beyond());
        }
        let mut points: Vec<Point> = Vec::new();
        for k in 0..POINTS {
            let at = from + (to - from) * k as f64 / (POINTS - 1) as f64;
            let covering: Vec<[f64; 2]> = curves.iter().filter_map(|one| one.at(at)).collect();
            let fold = |of: usize, pick: fn(f64, f64) -> f64| covering.iter().map(|one| one[of]).reduce(pick);
            let (Some(slow), Some(fast), Some(early), Some(late)) =
                (fold(0, f64::min), fold(0, f64::max), fold(1, f64::min), fold(1, f64::max))
            else {
                continue;
            };
            let speed = rounded((0.5 * (slow + fast)).exp().min(MAX_HAMMER_M_PER_S), 1.0);
            if points.last().is_none_or(|last| speed < last.hammer_speed_m_per_s) {
                points.push(Point {
                    between_s: 1e-3 * rounded(at.exp(), 1e-3),
                    hammer_speed_m_per_s: speed,
                    delay_s: 1e-3 * rounded(0.5 * (early + late), 1e-3),
                    touch_counts: rounded(0.5 * COUNTS_PER_E * (fast - slow), 1.0),
                });
            }
        }
        SpeedTable::new(&points).map_err(|_| beyond())
    }

    /// Contacts at these depths, m, the upper one first, whose tables are those of the simulated action. A note ends
    /// with the contact that is the nearest to where the key sets its damper down, the lowest excepted.
    ///
    /// # Errors
    /// [`ContactTableError`].
    pub fn law(&self, depths_m: &[f64], period_s: f64, bounce_s: f64) -> Result<ContactLaw, ContactTableError> {
        let count = depths_m.len();
        if !(2..=MAX_CONTACTS).contains(&count) {
            return Err(ContactFault::Count(count).into());
        }
        if let Some(i) = (1..count).find(|&i| depths_m[i] <= depths_m[i - 1]) {
            return Err(ContactFault::Depth(1e3 * depths_m[i]).into());
        }
        let mut all = [0.0; MAX_CONTACTS];
        all[..count].copy_from_slice(depths_m);
        let last = count - 1;
        let off_m = |i: &usize| (depths_m[*i] - self.damper_m).abs();
        let off = (0..last).min_by(|a, b| off_m(a).total_cmp(&off_m(b))).unwrap_or(0);
        let first = self.table(depths_m[0], depths_m[last])?;
        let mut tables = [first; MAX_CONTACTS - 1];
        for upper in 1..last {
            tables[upper] = self.table(depths_m[upper], depths_m[last])?;
        }
        let law = ContactLaw { depths_m: all, count, tables, period_s, phases_s: [0.0; MAX_CONTACTS], bounce_s, off };
        law.check()?;
        Ok(law)
    }

    /// The two depths, m, whose table errs least for a period of the scan, s, and the root mean square of its errors,
    /// counts.
    #[must_use]
    pub fn best(&self, period_s: f64) -> Option<([f64; 2], f64)> {
        let depth = |k: u32| LEAST_M + COMPARED_M * f64::from(k);
        let last = ((self.dip_m - ABOVE_M - LEAST_M) / COMPARED_M) as u32;
        let pairs = (0..last).flat_map(|upper| (upper + 1..=last).map(move |lower| [depth(upper), depth(lower)]));
        let judged = |pair: [f64; 2]| Some((pair, error_counts(&self.table(pair[0], pair[1]).ok()?, period_s)));
        pairs.filter_map(judged).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Logarithm of the speed and delay of a touch by the logarithm of the time between two contacts.
    fn curve(&self, touch: usize, upper_m: f64, lower_m: f64) -> Option<Curve> {
        let own = || self.all.iter().filter(|one| one.touch == touch && one.from_m < upper_m - OPENS_M);
        // A re-strike begins as near above the upper contact as it can.
        let deepest_m = own().map(|one| one.from_m).fold(f64::NEG_INFINITY, f64::max);
        let mut points: Vec<[f64; 3]> = own()
            .filter(|one| one.from_m > deepest_m - 0.1e-3)
            .filter_map(|one| {
                let [from_s, to_s] = [one.passes_s(upper_m, self.h)?, one.passes_s(lower_m, self.h)?];
                Some([(to_s - from_s).ln(), one.impact[1].ln(), one.impact[0] - to_s])
            })
            .collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points.dedup_by(|b, a| b[0] - a[0] < 1e-6);
        (points.len() > 2).then_some(Curve(points))
    }
}

/// Root mean square of a table's errors at its points, of touch and of time, for a period of the scan, s; counts.
#[must_use]
pub fn error_counts(table: &SpeedTable, period_s: f64) -> f64 {
    let square = |point: &Point| {
        let time_counts = table.time_counts(point.between_s, period_s);
        point.touch_counts * point.touch_counts + time_counts * time_counts
    };
    (table.points().iter().map(square).sum::<f64>() / table.points().len() as f64).sqrt()
}

impl Press {
    /// When the key first passes a depth on its way down, s.
    fn passes_s(&self, depth_m: f64, h: f64) -> Option<f64> {
        let i = self.key_m.windows(2).position(|pair| pair[0] < depth_m && pair[1] >= depth_m)?;
        let [x0, x1] = [self.key_m[i], self.key_m[i + 1]];
        Some(h * (i as f64 + (depth_m - x0) / (x1 - x0)))
    }
}

/// Points of a touch: logarithms of time and speed, and delay, s.
struct Curve(Vec<[f64; 3]>);

impl Curve {
    fn ends(&self) -> [f64; 2] {
        [self.0[0][0], self.0[self.0.len() - 1][0]]
    }

    /// Logarithm of the speed, and delay, s; `None` beyond the touch's ends.
    fn at(&self, x: f64) -> Option<[f64; 2]> {
        let [from, to] = self.ends();
        let tiny = 1e-9;
        if !(from - tiny..=to + tiny).contains(&x) {
            return None;
        }
        let end = (1..self.0.len() - 1).find(|&i| x <= self.0[i][0]).unwrap_or(self.0.len() - 1);
        let ([x0, v0, d0], [x1, v1, d1]) = (self.0[end - 1], self.0[end]);
        let share = (x - x0) / (x1 - x0);
        Some([v0 + share * (v1 - v0), d0 + share * (d1 - d0)])
    }
}

/// A number in a unit, to four decimals: profiles hold these digits, so that a table has the same bits once it was
/// written and read.
pub(crate) fn rounded(number: f64, unit: f64) -> f64 {
    (1e4 * number / unit).round() / 1e4
}

/// Numbers in ratios of [`RATIO`].
fn ratios([from, to]: [f64; 2]) -> Vec<f64> {
    let count = ((to / from).ln() / RATIO.ln()).ceil() as i32;
    (0..=count).map(|k| from * (to / from).powf(f64::from(k) / f64::from(count))).collect()
}

fn restore(action: &mut Action, state: &Snapshot) {
    // A snapshot of this very action.
    let _ = action.restore(state);
}

/// The finger on a path from a depth, m.
fn finger(from_m: f64, path: &[Leg], t: f64) -> Result<Input, HandError> {
    let [position_m, velocity_m_per_s] = place(from_m, path, t);
    FINGER.input(&Input::Motion { position_m, velocity_m_per_s })
}
