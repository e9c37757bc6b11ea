//! Influence of an instrument's parameters: derivatives of a stroke's results by them.
//!
//! Speeds and instants are differentiated in one pass each ([`erard::gradient`]): exact to first order, apart from
//! errors of the step length. This is done with three steps, `SHARES` of the stroke's. The middle result is reported
//! with half the range of all three, which is no error bar. Where they do not agree there is no derivative, and the row
//! names the friction switch at which they begin to differ. They are compared with differences in steps of two lengths
//! over a window that is wide against the resolution of a step. The error of these differences contains the change
//! between two windows and the error of the time step. Where derivative and differences disagree beyond their errors,
//! the row is marked and says why, as far as wider and narrower windows show it. Touch weights are the largest and the
//! smallest force of a slow loop, and have differences only.

mod differences;
mod error;
mod gradient;
mod mark;
mod parting;
mod passes;
mod variable;

pub use error::SensitivityError;
pub(crate) use gradient::Sampled;
pub use gradient::{Differentiation, Gradient, SHORTER, ValueAndSlopes, gradient};
pub use mark::Mark;
use mark::SHARES;
pub use parting::{Event, Refusal};
pub use passes::Rest;
pub use variable::{Variable, VariableError};

use erard::Progress;
use erard::gradient::{DIRECTIONS, Number, QUANTITIES};
use erard::instrument::Instrument;
use erard::run::Setup;

use crate::study::Stroke;
use differences::{Differences, OtherWindows, STEPS, Window};
use gradient::{NEGLIGIBLE, converges};
use mark::STEP_ERROR;
use parting::parting;
use passes::{How, Passes, passes};

/// A quantity that can be differentiated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensitivityOutcome {
    /// Name of the quantity, which ends with its unit.
    pub key: &'static str,
    /// Label of the quantity.
    pub label: &'static str,
    /// Unit for display.
    pub unit: &'static str,
    /// Whether that unit is a thousandth of the SI unit.
    pub thousandths: bool,
    /// Method of differentiation.
    pub method: Method,
}

/// Origin of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By numbers that carry derivatives.
    Gradient,
    /// By differences.
    Differences,
}

impl Method {
    /// Returns the name in results.
    pub fn name(self) -> &'static str {
        match self {
            Method::Gradient => "gradient",
            Method::Differences => "differences",
        }
    }
}

/// Default results.
pub const USUAL: [&str; 5] =
    ["hammer_speed_m_per_s", "let_off_s", "key_bottom_after_impact_s", "down_weight_g", "balance_weight_g"];

/// Returns all quantities that can be differentiated.
pub fn quantities() -> Vec<SensitivityOutcome> {
    let told = [
        ("hammer_speed_m_per_s", "hammer speed", "m/s", false),
        ("let_off_s", "last push", "ms", true),
        ("hammer_contact_s", "hammer meets the string", "ms", true),
        ("key_bottom_s", "key meets its bottom", "ms", true),
        ("key_bottom_after_impact_s", "key bottom after the impact", "ms", true),
        ("free_flight_s", "free flight", "ms", true),
        ("key_start_s", "key start", "ms", true),
        ("toe_contact_s", "toe meets the button", "ms", true),
        ("key_start_to_hammer_s", "key start to hammer", "ms", true),
    ];
    let followed = told.map(|(key, label, unit, thousandths)| SensitivityOutcome {
        key,
        label,
        unit,
        thousandths,
        method: Method::Gradient,
    });
    let weight =
        |key, label| SensitivityOutcome { key, label, unit: "g", thousandths: false, method: Method::Differences };
    let weights = [
        weight("down_weight_g", "down-weight"),
        weight("up_weight_g", "up-weight"),
        weight("balance_weight_g", "balance weight"),
    ];
    followed.into_iter().chain(weights).collect()
}

/// Derivative of a quantity by a variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Quantity: place in [`Sensitivities::of`].
    pub of: usize,
    /// Variable: index in [`Sensitivities::by`].
    pub by: usize,
    /// Change of the quantity (SI units, or g) per unit of the number ([`Variable::per`]); NaN if it does not converge.
    pub derivative: f64,
    /// Half the range of the derivatives for three step lengths, plus the uncertainty from unresolved friction
    /// switches; or the difference between two windows. No error bar: it lacks errors common to all step lengths.
    pub spread: f64,
    /// Differences over the window in the shortest step, and their error: the change between two windows, and for
    /// results of the stroke the error of the time step. `None` if the number cannot be changed to both sides.
    pub differences: Option<[f64; 2]>,
    /// Differences downward and upward.
    pub sides: Option<[f64; 2]>,
    /// Reason of the mark: the friction switch from which on derivatives that do not converge differ, or why derivative
    /// and differences disagree.
    pub reason: Option<String>,
    /// Remark on the derivative.
    pub mark: Mark,
}

impl Sensitivity {
    /// Change of the quantity for the number's usual change ([`Variable::usual`]).
    pub fn effect(&self, all: &Sensitivities) -> f64 {
        self.derivative * all.by[self.by].usual
    }

    /// Relative change of the quantity over relative change of the number; `None` if either is undefined.
    pub fn elasticity(&self, all: &Sensitivities) -> Option<f64> {
        let value = all.values[self.of]?;
        let own = all.by[self.by].relative()?;
        (value != 0.0).then(|| self.derivative * own / value)
    }
}

/// All derivatives of a stroke's results.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    /// Quantities.
    pub of: Vec<SensitivityOutcome>,
    /// Values of the quantities; `None` for events that did not happen.
    pub values: Vec<Option<f64>>,
    /// Variables of the derivatives.
    pub by: Vec<Variable>,
    /// Derivatives of every quantity that occurred, by quantity, the largest effect first.
    pub rows: Vec<Sensitivity>,
    /// Friction switches from the pose as drawn to the impact: those at which derivatives jumped, and unresolved ones.
    pub switches: [u32; 2],
}

/// Weights of the progress: gradients, strokes for differences, weighing, strokes over further windows.
const PARTS: [f64; 4] = [1.0, 1.0, 20.0, 0.5];

/// Computes the derivatives of a stroke's results by an instrument's parameters.
///
/// `stroke` makes the drive of the key. `progress` receives the share done and ends the work by returning false.
///
/// # Errors
/// A press that cannot be differentiated or played. A number that cannot be changed is no error but marked.
#[allow(clippy::too_many_arguments)]
pub fn sensitivities<'a>(
    instrument: &Instrument,
    by: Vec<Variable>,
    of: Vec<SensitivityOutcome>,
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    rest: Rest,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Sensitivities, SensitivityError> {
    // Outlines are for drawings.
    let instrument = &instrument.clone().without_outlines();
    let weighed = of.iter().any(|one| one.method == Method::Differences);
    let followed = of.iter().any(|one| one.method == Method::Gradient);
    let parts = [
        if followed { PARTS[0] } else { 0.0 },
        if followed { PARTS[1] } else { 0.0 },
        if weighed { PARTS[2] } else { 0.0 },
        if followed { PARTS[3] } else { 0.0 },
    ];
    let total: f64 = parts.iter().sum();
    let mut tell =
        |part: usize, share: f64| progress((parts[..part].iter().sum::<f64>() + share * parts[part]) / total);
    let how = How { rest, shares: &SHARES, sample_every: None, threads };
    let found = match followed {
        true => passes(instrument, &by, stroke, setup, &how, &mut |share| tell(0, share))?,
        false => Passes::default(),
    };
    let variables = by.clone();
    let window = Window::new(instrument, &variables, &|one| one.window);
    let heavy = Window::new(instrument, &variables, &|one| one.weighing);
    // Differences include the change of the rest.
    let played = match followed && rest == Rest::Moves {
        true => window.play_in_steps(&STEPS, stroke, setup, threads, &mut |share| tell(1, share))?,
        false => Vec::new(),
    };
    let weights = match weighed {
        true => heavy.weigh(threads, &mut |share| tell(2, share))?,
        false => Vec::new(),
    };
    let switches = found.switches();
    let mut all = Sensitivities { values: vec![None; of.len()], of, by, rows: Vec::new(), switches };
    for (k, quantity) in all.of.iter().enumerate() {
        let mut rows = Vec::new();
        let gradient = QUANTITIES.iter().find(|(key, _)| *key == quantity.key);
        for (i, variable) in all.by.iter().enumerate() {
            let place = [k, i];
            match gradient {
                Some((_, get)) => {
                    let pass = |which: usize| found.one(which, i).and_then(|f| get(&f.instants));
                    let [Some(a), Some(b), Some(c)] = [pass(0), pass(1), pass(2)] else { continue };
                    all.values[k] = Some(c.value);
                    let differences = window.of_events(&played, &STEPS, i, quantity.key);
                    let slopes = [a, b, c].map(|x: Number| x.slope[i % DIRECTIONS]);
                    let passing = found.passing(i).and_then(|f| get(&f.instants));
                    let unresolved = passing.map_or(0.0, |x| (x - a).slope[i % DIRECTIONS].abs());
                    let mut row = judged(place, slopes, unresolved, differences, variable.usual, c.value);
                    if rest == Rest::Held && row.mark == Mark::OneSided {
                        row.mark = Mark::None;
                    }
                    if !found.has_rest(i) && row.derivative.abs() * variable.usual > NEGLIGIBLE * c.value.abs() {
                        row.mark = Mark::Unconverged;
                        row.reason = Some("the rest position has a different slope on either side".to_owned());
                    } else if row.mark == Mark::Unconverged {
                        let [first, second] = [0, 2].map(|which| found.one(which, i));
                        let event = first.zip(second).and_then(|(a, b)| parting(a, b, i % DIRECTIONS));
                        row.reason = event.map(|event| event.told(instrument));
                    }
                    if row.mark == Mark::Unconverged {
                        row.derivative = f64::NAN;
                    }
                    if row.mark == Mark::Jumps {
                        row.reason = Some("the slopes to the two sides differ: a corner or a jump".to_owned());
                    }
                    rows.push(row);
                }
                None => {
                    all.values[k] = weights.first().and_then(|w| differences::weight(w, quantity.key));
                    let Some(found) = heavy.of_weights(&weights, i, quantity.key) else { continue };
                    let mark = if found.jumps() { Mark::Jumps } else { Mark::None };
                    rows.push(row_of(place, found.slope, found.error, Some(found), mark));
                }
            }
        }
        all.rows.extend(rows);
    }
    // Strokes over further windows, for the numbers of rows that disagree.
    let disagree = |by: usize| all.rows.iter().any(|row| row.by == by && row.mark == Mark::Apart);
    let places: Vec<usize> = (0..variables.len()).filter(|&by| disagree(by)).collect();
    if !places.is_empty() {
        let doubtful: Vec<Variable> = places.iter().map(|&by| variables[by].clone()).collect();
        let others = OtherWindows::play(instrument, &doubtful, stroke, setup, threads, &mut |share| tell(3, share))?;
        for row in all.rows.iter_mut().filter(|row| row.mark == Mark::Apart) {
            let Ok(place) = places.binary_search(&row.by) else { continue };
            let key = all.of[row.of].key;
            let first = window.of_events(&played, &STEPS, row.by, key);
            let (mark, reason) = others.why(place, key, [row.derivative, row.spread], first);
            (row.mark, row.reason) = (mark, Some(reason));
        }
    }
    // By quantity, the largest effect first; rows that do not converge are sorted by their differences.
    let size = |row: &Sensitivity| {
        let slope = match row.mark {
            Mark::Unconverged => row.differences.map_or(0.0, |[slope, _]| slope),
            _ => row.derivative,
        };
        (slope * variables[row.by].usual).abs()
    };
    all.rows.sort_by(|a, b| a.of.cmp(&b.of).then(size(b).total_cmp(&size(a))));
    Ok(all)
}

fn row_of(
    [of, by]: [usize; 2],
    derivative: f64,
    spread: f64,
    differences: Option<Differences>,
    mark: Mark,
) -> Sensitivity {
    let sides = differences.map(|found| found.sides);
    let differences = differences.map(|found| [found.slope, found.error]);
    Sensitivity { of, by, derivative, spread, differences, sides, reason: None, mark }
}

/// Judges derivatives for three step lengths by differences.
fn judged(
    place: [usize; 2],
    mut slopes: [f64; 3],
    unresolved: f64,
    differences: Option<Differences>,
    usual: f64,
    value: f64,
) -> Sensitivity {
    slopes.sort_by(f64::total_cmp);
    let [least, slope, most] = slopes;
    let spread = 0.5 * (most - least) + unresolved;
    let mark = if !converges(slope - spread, slope + spread, usual, value) {
        Mark::Unconverged
    } else if let Some(found) = differences {
        // A change of the quantity below a hundred-thousandth does not matter, whatever its mark.
        let matters = (slope * usual).abs() > NEGLIGIBLE * value.abs() || found.matters(value);
        if !matters {
            Mark::None
        } else if found.jumps() {
            Mark::Jumps
        } else if (slope - found.slope).abs() > STEP_ERROR * spread + found.error {
            // Why is found later, over further windows.
            Mark::Apart
        } else {
            Mark::None
        }
    } else {
        Mark::OneSided
    };
    row_of(place, slope, spread, differences, mark)
}
