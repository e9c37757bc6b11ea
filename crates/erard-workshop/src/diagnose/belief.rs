//! Probability of every cause, alone and with others, from the readings.
//!
//! Under a set of causes the readings are normal: the mean of sound keys plus the effects of the causes, with the
//! covariance of sound keys, the scatter of effects from grand to grand, and the reading's own error. A cause has
//! grades between its light and its heavy case, all equally likely, and beyond it up to the largest size that is met,
//! half as likely. The reading less the effects lies in the range of sound keys. Sets of up to four causes are
//! compared; their prior is the product of the causes' odds. A reading that was taken proves that its event took place:
//! a cause that prevents the event seldom is there. One more hypothesis represents other faults, with readings
//! anywhere.

use super::cause::causes;
use super::cause::{Cause, Change};
use super::effect::{BALANCE, CHECK, Effect, FEATURES, FRICTION, Features, N, NOT_CAUGHT_MM, effects, precision};
use super::entry::at::STRIKE;
use super::geometry::{Band, Follows};
use super::healthy::{Healthy, set_by};
use super::inject::injected_amount;
use super::normal::{log_density, log_sum};
use crate::dense::Cholesky;

/// Grades of a cause: the cases of the table, and those half-way between.
const GRADES: usize = 5;
/// Largest number of causes in a set, and number of sets of each size that are extended.
const MAX_CAUSES: usize = 4;
const BEAM: usize = 80;
/// A quarter of this many sets predict readings; four times as many are kept of each size.
const KEPT: usize = 200;
/// Odds of a fault without a cause in the table: an estimate.
const OTHER: f64 = 0.003;
/// Spread of the readings then, in standard deviations of sound keys.
const ANYWHERE: f64 = 8.0;

/// A reading: a sum of features, its value, its standard error, and the range of sound keys, in which the reading less
/// the effects of causes lies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    pub of: Vec<(usize, f64)>,
    pub value: f64,
    pub error: f64,
    pub range: Option<[f64; 2]>,
}

/// Least logarithm of the probability that a key is sound outside its range: ranges are not that sharp.
const LEAST_IN_RANGE: f64 = -6.0;

impl Row {
    /// A feature as read: uniform within its precision, so that its standard error is the precision over the root of 3.
    pub(super) fn of(feature: usize, value: f64) -> Self {
        // Balance and friction weight come from two readings each: their errors are smaller by the root of 2.
        let share = if [BALANCE, FRICTION].contains(&feature) { 6.0 } else { 3.0 };
        Row { of: vec![(feature, 1.0)], value, error: precision(feature) / libm::sqrt(share), range: None }
    }

    /// The hammer is not caught.
    pub(super) fn not_caught() -> Self {
        let [value, error] = NOT_CAUGHT_MM;
        Row { of: vec![(CHECK, 1.0)], value, error, range: None }
    }

    /// Features within a band of added largest errors, which are about three times the standard error of their sum.
    pub(super) fn of_band(of: Vec<(usize, f64)>, band: Band, range: Option<[f64; 2]>) -> Self {
        let (value, largest) = band.middle_and_error();
        Row { of, value, error: largest / 3.0, range }
    }

    /// What follows from other readings.
    pub(super) fn following(follows: &Follows) -> Self {
        let Follows { of, without, value, usual, .. } = follows;
        let band = Band { low: value.low + without, high: value.high + without };
        Row::of_band(of.iter().map(|feature| (*feature, 1.0)).collect(), band, Some(usual.map(|end| end + without)))
    }

    /// The same with the range of sound keys.
    pub(super) fn within(self, range: Option<[f64; 2]>) -> Self {
        Row { range, ..self }
    }

    fn project(&self, features: impl Fn(usize) -> f64) -> f64 {
        self.of.iter().map(|(feature, by)| by * features(*feature)).sum()
    }
}

/// A grade of a cause, with its effect on the features.
#[derive(Debug, Clone)]
struct Atom {
    cause: usize,
    case: f64,
    /// Logarithm of its prior odds.
    prior: f64,
    /// Features whose events it prevents.
    prevents: [bool; N],
    mean: [f64; N],
    /// Half the distance to the next grades, as a standard deviation.
    along: [f64; N],
    spread: [f64; N],
    /// Feature of a screw that was set again, so that it is where that put it.
    loose: Option<usize>,
}

/// A set of graded causes.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis {
    /// Indices of atoms.
    atoms: Vec<usize>,
    is_other: bool,
    /// Logarithm of prior times likelihood; normalised by [`Belief::of`].
    pub log: f64,
}

/// Probabilities of all hypotheses.
#[derive(Debug)]
pub(super) struct Belief {
    healthy: Healthy,
    rows: Vec<Row>,
    /// What follows from the rows: it says nothing new but whether it lies in its range.
    follows: Vec<Row>,
    atoms: Vec<Atom>,
    /// The sets, the most likely first.
    pub sets: Vec<Hypothesis>,
}

/// Relative uncertainty of an effect on a piano of another make: an estimate.
const ANOTHER_MAKE: f64 = 0.25;
/// Check distance of sound hammers, mm: the middle of 12 to 15.
const MIDDLE_OF_CHECK_MM: f64 = 13.5;
/// Standard deviation of a reading whose event a cause prevents on most grands, in precisions: an estimate.
const NOT_THERE: f64 = 3.0;
/// Probability that the event of a reading takes place although a cause prevents it on most grands: an estimate.
const TOOK_PLACE: f64 = 0.05;
/// Probability of a grade beyond the heavy case, relative to one up to it: an estimate.
const BEYOND: f64 = 0.5;
/// Standard deviation of a loose reading, mm: an estimate.
const LOOSE_MM: f64 = 2.0;
/// Uncertainty of the balance weight, g per gram of friction: Kawai KG-2 (CAUT list, March 2004), 45 g at a friction
/// weight of 25 g, 39 g at 9 g; in the model a tight flange adds 0.14 g.
pub(super) const BALANCE_PER_FRICTION: f64 = 0.3;

/// Standard deviation of the ends of a range of sound keys: half a strike-weight curve, which a set of hammers may be
/// heavier than medium ones; else a quarter of a reading's precision. Estimates.
fn end_sd(feature: usize) -> f64 {
    if feature == STRIKE { 0.25 } else { 0.25 * precision(feature) }
}

fn feature(name: &str) -> usize {
    FEATURES.iter().position(|own| *own == name).unwrap_or_default()
}

fn atoms() -> Vec<Atom> {
    causes().iter().zip(effects()).enumerate().flat_map(|(at, (cause, cases))| atoms_of(at, cause, cases)).collect()
}

/// Spread of the effects of a grade: from grand to grand, and on a piano of another make.
fn spread_of(cause: &Cause, mean: &[f64; N], spread: &[f64; N]) -> [f64; N] {
    let mut all: [f64; N] = std::array::from_fn(|i| spread[i].hypot(ANOTHER_MAKE * mean[i]));
    if cause.order == 1 {
        all[BALANCE] = all[BALANCE].hypot(BALANCE_PER_FRICTION * mean[FRICTION]);
    }
    all
}

/// Amount of a cause in a case, as a multiple of the light one; of a friction, which is a factor, what it adds.
fn share_of_light(cause: &Cause, case: f64) -> f64 {
    let own = if matches!(cause.change, Change::Friction(_)) { 1.0 } else { 0.0 };
    (injected_amount(cause, case) - own) / (cause.amounts[0] - own)
}

/// Effect of a case of a cause: between the cases of the table. A screw that is set again after the largest case was
/// set again after those below it, too: they are shares of that case by the reading that the cause sets.
fn effect_at(cause: &Cause, cases: &[Effect], case: f64, is_beyond: bool) -> Effect {
    if let (true, Some(beyond), Some(_)) = (is_beyond, &cause.beyond, cause.set_again()) {
        let [heavy, largest] = [2, 3].map(|at| cases[at].mean[feature(&beyond.line)].unwrap_or(1.0));
        let share = (heavy + (case - 3.0) * (largest - heavy)) / largest;
        let Effect { mean, spread } = &cases[3];
        return Effect { mean: mean.map(|x| x.map(|x| share * x)), spread: spread.map(|x| share * x) };
    }
    let low = ((case - 1.0).floor() as usize).min(cases.len() - 2);
    let share = case - 1.0 - low as f64;
    let [a, b]: [&Effect; 2] = [&cases[low], &cases[low + 1]];
    let mix = |a: f64, b: f64| a + share * (b - a);
    let value = |i: usize| match (a.mean[i], b.mean[i]) {
        (Some(a), Some(b)) => Some(mix(a, b)),
        (a, b) => {
            if share < 0.5 {
                a
            } else {
                b
            }
        }
    };
    Effect { mean: std::array::from_fn(value), spread: std::array::from_fn(|i| mix(a.spread[i], b.spread[i])) }
}

/// Grades of a cause, as cases, each with the ends of what it represents: the cases of the table and those half-way
/// between, then up to the largest that is met in steps of the distance from the plain to the heavy one.
fn grades(cause: &Cause, cases: &[Effect]) -> Vec<(f64, [f64; 2])> {
    let step = 2.0 / (GRADES - 1) as f64;
    let within = (0..GRADES).map(|grade| 1.0 + step * grade as f64);
    let mut all: Vec<_> =
        within.map(|case| (case, [case - 0.5 * step, case + 0.5 * step].map(|end| end.clamp(1.0, 3.0)))).collect();
    if let Some(beyond) = &cause.beyond {
        let line = feature(&beyond.line);
        let [plain, heavy, largest] = [1, 2, 3].map(|at| cases[at].mean[line].unwrap_or(0.0));
        let way = (largest - heavy).abs();
        let step = (heavy - plain).abs().max(0.25 * way).max(precision(line));
        let steps = (way / step).ceil().max(1.0);
        let case = |n: u32| 3.0 + f64::from(n) / steps;
        all.extend((1..=steps as u32).map(|n| (case(n), [case(n - 1), case(n)])));
    }
    all
}

/// The graded effects of a cause.
fn atoms_of(at: usize, cause: &Cause, cases: &[Effect]) -> Vec<Atom> {
    let loose = cause.set_again().and_then(|(again, _)| set_by(again));
    let mut all = Vec::new();
    for (case, ends) in grades(cause, cases) {
        let is_beyond = case > 3.0;
        let effect = effect_at(cause, cases, case, is_beyond);
        let [before, after] = ends.map(|end| effect_at(cause, cases, end, is_beyond).mean);
        let mut prevents = effect.mean.map(|mean| mean.is_none());
        // A hammer that is no longer caught would have been caught low. An event that takes place all the same is
        // shifted in proportion to the light case.
        let mut mean: [f64; N] = std::array::from_fn(|i| {
            let shifted = cases[0].mean[i].unwrap_or(0.0) * share_of_light(cause, case);
            effect.mean[i].unwrap_or(if i == CHECK { NOT_CAUGHT_MM[0] - MIDDLE_OF_CHECK_MM } else { shifted })
        });
        let mut spread = spread_of(cause, &mean, &effect.spread);
        (0..N).filter(|i| prevents[*i]).for_each(|i| spread[i] = spread[i].hypot(NOT_THERE * precision(i)));
        let along = std::array::from_fn(|i| {
            before[i].zip(after[i]).map_or(0.0, |(before, after)| (after - before) / libm::sqrt(12.0))
        });
        let loose = loose.filter(|_| is_beyond);
        if let Some(loose) = loose {
            (mean[loose], spread[loose], prevents[loose]) = (0.0, LOOSE_MM, false);
        }
        all.push(Atom { cause: at, case, prior: 0.0, prevents, mean, along, spread, loose });
    }
    let weight = |case: f64| if case <= 3.0 { 1.0 } else { BEYOND };
    let total: f64 = all.iter().map(|atom| weight(atom.case)).sum();
    for atom in &mut all {
        atom.prior = libm::log(cause.common * weight(atom.case) / total);
    }
    all
}

/// Residuals and factor of the covariance of the readings under a hypothesis.
struct Predicted {
    off: Vec<f64>,
    factor: Cholesky,
}

impl Belief {
    /// Computes the probabilities for the readings of a key.
    pub(super) fn of(key: usize, rows: Vec<Row>, follows: Vec<Row>) -> Self {
        let mut belief = Belief { healthy: Healthy::at(key), rows, follows, atoms: atoms(), sets: Vec::new() };
        belief.search();
        belief
    }

    fn search(&mut self) {
        let nothing = Hypothesis { atoms: Vec::new(), is_other: false, log: 0.0 };
        let log = self.log_of(&[], false);
        let other = self.log_of(&[], true);
        let mut all = vec![Hypothesis { log, ..nothing.clone() }, Hypothesis { log: other, is_other: true, ..nothing }];
        let mut beam = vec![all[0].clone()];
        for size in 1..=MAX_CAUSES {
            let mut next: Vec<Hypothesis> = Vec::new();
            for set in &beam {
                for atom in 0..self.atoms.len() {
                    if set.atoms.iter().any(|own| self.are_at_odds(*own, atom)) {
                        continue;
                    }
                    // Sorted, so that the same sets are recognised and removed.
                    let mut atoms = set.atoms.clone();
                    atoms.push(atom);
                    atoms.sort_unstable();
                    next.push(Hypothesis { log: self.log_of(&atoms, false), atoms, is_other: false });
                }
            }
            next.sort_by(|a, b| b.log.total_cmp(&a.log).then_with(|| a.atoms.cmp(&b.atoms)));
            next.dedup_by(|a, b| a.atoms == b.atoms);
            all.extend(next.iter().take(4 * KEPT).cloned());
            next.truncate(BEAM);
            if size == MAX_CAUSES {
                break;
            }
            beam = next;
        }
        all.sort_by(|a, b| b.log.total_cmp(&a.log).then_with(|| a.atoms.cmp(&b.atoms)));
        let total = log_sum(all.iter().map(|set| set.log));
        all.iter_mut().for_each(|set| set.log -= total);
        self.sets = all;
    }

    /// Whether two grades exclude each other because they belong to one screw or part.
    fn are_at_odds(&self, a: usize, b: usize) -> bool {
        let part = |atom: usize| causes()[self.atoms[atom].cause].change;
        part(a) == part(b)
    }

    fn predicted(&self, atoms: &[usize], is_other: bool) -> Option<Predicted> {
        let n = self.rows.len();
        let mut covariance = vec![0.0; n * n];
        let healthy = &self.healthy;
        for (i, row) in self.rows.iter().enumerate() {
            for (j, other) in self.rows.iter().enumerate() {
                covariance[i * n + j] = row.project(|a| other.project(|b| healthy.covariance[a][b]));
            }
            let own = covariance[i * n + i];
            covariance[i * n + i] += row.error * row.error;
            if is_other {
                covariance[i * n + i] += ANYWHERE * ANYWHERE * own;
            }
        }
        let mut off: Vec<f64> = self.rows.iter().map(|row| row.value - row.project(|i| healthy.mean[i])).collect();
        for atom in atoms.iter().map(|atom| &self.atoms[*atom]) {
            let along: Vec<f64> = self.rows.iter().map(|row| row.project(|i| atom.along[i])).collect();
            for (i, row) in self.rows.iter().enumerate() {
                off[i] -= row.project(|i| atom.mean[i]);
                for j in 0..n {
                    covariance[i * n + j] += along[i] * along[j];
                }
                covariance[i * n + i] += row.of.iter().map(|(f, by)| (by * atom.spread[*f]).powi(2)).sum::<f64>();
            }
        }
        Some(Predicted { off, factor: Cholesky::of(&covariance, n)? })
    }

    fn log_of(&self, atoms: &[usize], is_other: bool) -> f64 {
        let prior: f64 = atoms.iter().map(|atom| self.atoms[*atom].prior).sum::<f64>()
            + if is_other { libm::log(OTHER) } else { 0.0 };
        let taken = |atom: &&Atom| {
            let is_prevented = |row: &&Row| row.of.iter().any(|(f, _)| *f != CHECK && atom.prevents[*f]);
            self.rows.iter().filter(is_prevented).count() as f64
        };
        let prevented: f64 = atoms.iter().map(|atom| taken(&&self.atoms[*atom])).sum();
        let rows = self.rows.iter().chain(&self.follows);
        let in_range: f64 = rows.map(|row| self.in_range(row, atoms, is_other)).sum();
        let prior = prior + prevented * libm::log(TOOK_PLACE) + in_range;
        match self.predicted(atoms, is_other) {
            Some(predicted) => prior + log_density(&predicted.factor, &predicted.off),
            None => f64::NEG_INFINITY,
        }
    }

    /// Logarithm of the probability that a reading less the effects of these causes lies in the range of sound keys.
    fn in_range(&self, row: &Row, atoms: &[usize], is_other: bool) -> f64 {
        let Some([low, high]) = row.range else { return 0.0 };
        let is_loose =
            |atom: &usize| self.atoms[*atom].loose.is_some_and(|loose| row.of.iter().any(|(f, _)| *f == loose));
        if atoms.iter().any(is_loose) {
            return 0.0;
        }
        let end: f64 = row.of.iter().map(|(feature, _)| end_sd(*feature).powi(2)).sum();
        let (mut sound, mut variance) = (row.value, row.error * row.error + end);
        if is_other {
            let own = row.project(|a| row.project(|b| self.healthy.covariance[a][b]));
            variance += ANYWHERE * ANYWHERE * own;
        }
        for atom in atoms.iter().map(|atom| &self.atoms[*atom]) {
            sound -= row.project(|i| atom.mean[i]);
            variance +=
                row.of.iter().map(|(f, by)| by * by * (atom.spread[*f].powi(2) + atom.along[*f].powi(2))).sum::<f64>();
        }
        let sd = libm::sqrt(variance);
        // The share of a normal distribution above an end, 1 for an open one below.
        let above = |end: f64| 0.5 * libm::erfc((end - sound) / (sd * std::f64::consts::SQRT_2));
        libm::log(above(low) - above(high)).max(LEAST_IN_RANGE)
    }

    /// Returns the probability of every cause.
    pub(super) fn of_causes(&self) -> Vec<f64> {
        let mut of = vec![0.0; causes().len()];
        for set in &self.sets {
            for atom in &set.atoms {
                of[self.atoms[*atom].cause] += libm::exp(set.log);
            }
        }
        of
    }

    /// Returns the probability that two causes are there together.
    pub(super) fn together(&self, a: usize, b: usize) -> f64 {
        let holds = |set: &Hypothesis, cause: usize| set.atoms.iter().any(|atom| self.atoms[*atom].cause == cause);
        let both = self.sets.iter().filter(|set| holds(set, a) && holds(set, b));
        both.map(|set| libm::exp(set.log)).sum()
    }

    /// Returns the probabilities that something else is wrong, and that nothing is.
    pub(super) fn of_other_and_none(&self) -> [f64; 2] {
        let sum = |is_other: bool| {
            let of = self.sets.iter().filter(|set| set.atoms.is_empty() && set.is_other == is_other);
            of.map(|set| libm::exp(set.log)).sum()
        };
        [sum(true), sum(false)]
    }

    /// Returns the mean case of a cause, 1 light to 3 heavy, and its mean effect on the features.
    pub(super) fn case_and_change(&self, cause: usize) -> (f64, Features) {
        let (mut weight, mut case, mut change) = (0.0, 0.0, [0.0; N]);
        for set in &self.sets {
            for atom in set.atoms.iter().map(|atom| &self.atoms[*atom]).filter(|atom| atom.cause == cause) {
                let p = libm::exp(set.log);
                weight += p;
                case += p * atom.case;
                (0..N).for_each(|i| change[i] += p * atom.mean[i]);
            }
        }
        (case / weight, change.map(|x| Some(x / weight)))
    }

    /// Returns the most likely sets: probability, causes, and mean and standard deviation of an unread feature.
    pub(super) fn foretold(&self, feature: usize) -> Vec<(f64, Vec<usize>, f64, f64)> {
        let n = self.rows.len();
        let mut told = Vec::new();
        for set in self.sets.iter().filter(|set| !set.is_other).take(KEPT / 4) {
            let Some(predicted) = self.predicted(&set.atoms, false) else { continue };
            let mut mean = self.healthy.mean[feature];
            let mut variance = self.healthy.covariance[feature][feature] + precision(feature).powi(2) / 3.0;
            let mut with: Vec<f64> =
                self.rows.iter().map(|row| row.project(|i| self.healthy.covariance[i][feature])).collect();
            for atom in set.atoms.iter().map(|atom| &self.atoms[*atom]) {
                mean += atom.mean[feature];
                variance += atom.along[feature].powi(2) + atom.spread[feature].powi(2);
                for (i, row) in self.rows.iter().enumerate() {
                    with[i] += atom.along[feature] * row.project(|f| atom.along[f]);
                }
            }
            let [z, w] = [&predicted.off, &with].map(|b| predicted.factor.forward(b));
            mean += (0..n).map(|i| z[i] * w[i]).sum::<f64>();
            variance -= w.iter().map(|w| w * w).sum::<f64>();
            let causes = set.atoms.iter().map(|atom| self.atoms[*atom].cause).collect();
            told.push((libm::exp(set.log), causes, mean, libm::sqrt(variance.max(1e-12))));
        }
        told
    }
}
