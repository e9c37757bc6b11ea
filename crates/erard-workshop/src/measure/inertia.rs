//! Effective mass at the key front: the kinetic energy of the whole action over half the square of the key front's
//! speed, through the stroke.
//!
//! Until let-off begins, whippen and hammer follow the key by geometry: their speeds are those of the three levers at
//! the same key travel (`levers.rs`), the damper's that of its contact with the key. Afterwards the jack slips away and
//! the hammer flies by itself; no single mass represents the action any more.

use moreau::Settings;

use super::MeasureError;
use super::levers::{Levers, rigid};
use erard::Progress;
use erard::grand::Parts;
use erard::instrument::Instrument;
use erard::mechanism::Mechanism;
use erard::player::{Action, AtRest, Input};

/// Points of the curve.
const POINTS: usize = 40;
/// Step, s.
const STEP_S: f64 = 100e-6;
/// Time from point to point, s: slow compared with the hammer's swing on its felts.
const BETWEEN_S: f64 = 0.03;

/// Effective mass at the key front through the stroke.
#[derive(Debug, Clone, PartialEq)]
pub struct InertiaCurve {
    /// Key travel, m, from rest to where let-off begins.
    pub key_m: Vec<f64>,
    /// Effective mass with the damper out of the key's reach, kg.
    pub pedal_down_kg: Vec<f64>,
    /// Effective mass with the damper on the string, kg; equal to `pedal_down_kg` until the key lifts the damper.
    pub dampers_down_kg: Vec<f64>,
    /// Shares half-way, with the damper out of reach.
    pub half_way: Shares,
}

/// Shares of the parts in the inertia, kg at the key front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Share of the key.
    pub key_kg: f64,
    /// Share of whippen, jack and repetition lever.
    pub whippen_kg: f64,
    /// Share of the hammer.
    pub hammer_kg: f64,
}

impl Shares {
    /// Returns the total, kg.
    #[must_use]
    pub fn total_kg(&self) -> f64 {
        self.key_kg + self.whippen_kg + self.hammer_kg
    }
}

/// Computes the effective inertia from rest to `way_m`, the end of the free travel, where let-off begins. Bends are
/// locked.
///
/// # Errors
/// See [`MeasureError`].
pub fn inertia(action: &dyn AtRest, way_m: f64, progress: &mut Progress<'_>) -> Result<InertiaCurve, MeasureError> {
    let rest = rigid(action, progress)?;
    let instrument = rest.instrument();
    let parts = Parts::of(instrument)?;
    let mut levers = Levers::of(&*rest)?;
    let key_front_m = levers.key_front_m;
    let mut rates = |key_m: f64| levers.ratios(key_m).map(|ratios| Rates::new(instrument, &parts, ratios));
    let mut action = rest.action(Settings::new(STEP_S))?;
    let key_m: Vec<f64> = (0..=POINTS).map(|point| point as f64 / POINTS as f64 * way_m).collect();
    let (mut pedal_down_kg, mut dampers_down_kg) = (Vec::new(), Vec::new());
    let mut before_m = 0.0;
    for &key_m in &key_m {
        carry_on(&mut action, [before_m, key_m], progress)?;
        before_m = key_m;
        let rates = rates(key_m)?;
        let m = action.mechanism();
        pedal_down_kg.push(rates.mass(m, key_front_m, &rates.all));
        dampers_down_kg.push(rates.mass(m, key_front_m, &rates.with_damper(&parts, m)));
    }
    // The shares need no pose of their own: kinetic energies of single bodies, half-way.
    let half_m = key_m[POINTS / 2];
    let mut action = rest.action(Settings::new(STEP_S))?;
    carry_on(&mut action, [0.0, half_m], progress)?;
    let rates = rates(half_m)?;
    let share = |of: &dyn Fn(usize) -> bool| {
        let some: Vec<f64> = rates.all.iter().enumerate().map(|(b, rate)| if of(b) { *rate } else { 0.0 }).collect();
        rates.mass(action.mechanism(), key_front_m, &some)
    };
    let whippen: Vec<usize> = Parts::riders(instrument, parts.whippen).collect();
    let half_way = Shares {
        key_kg: share(&|b| b == parts.key),
        whippen_kg: share(&|b| whippen.contains(&b)),
        hammer_kg: share(&|b| b == parts.hammer),
    };
    Ok(InertiaCurve { key_m, pedal_down_kg, dampers_down_kg, half_way })
}

/// Angular velocity of every body per unit of the key's.
struct Rates {
    all: Vec<f64>,
}

impl Rates {
    fn new(instrument: &Instrument, parts: &Parts, [whippen, hammer]: [f64; 2]) -> Self {
        let mut all = vec![0.0; instrument.bodies.len()];
        all[parts.key] = 1.0;
        all[parts.hammer] = hammer;
        for body in Parts::riders(instrument, parts.whippen) {
            all[body] = whippen;
        }
        Rates { all }
    }

    /// Adds the damper where its contact with the key is closed.
    fn with_damper(&self, parts: &Parts, m: &dyn Mechanism) -> Vec<f64> {
        let mut all = self.all.clone();
        if let Some((zone, damper)) = parts.damper.filter(|&(zone, _)| m.compression(zone) > 0.0) {
            let row = m.compression_row(zone);
            all[damper] = -row[parts.key] / row[damper];
        }
        all
    }

    /// Twice the kinetic energy over the square of the key front's speed.
    fn mass(&self, m: &dyn Mechanism, key_front_m: f64, rates: &[f64]) -> f64 {
        2.0 * m.energies_at(rates).kinetic / (key_front_m * key_front_m)
    }
}

/// Moves the finger from one depth to the next.
fn carry_on(action: &mut Action, [from_m, to_m]: [f64; 2], progress: &mut Progress<'_>) -> Result<(), MeasureError> {
    let steps = (BETWEEN_S / STEP_S) as u64;
    let mut middles = (0..steps).map(|n| (n as f64 + 0.5) / steps as f64);
    action.play(progress, &mut |_| {
        let position_m = from_m + middles.next()? * (to_m - from_m);
        Some(Input::Motion { position_m, velocity_m_per_s: (to_m - from_m) / BETWEEN_S })
    })?;
    Ok(())
}
