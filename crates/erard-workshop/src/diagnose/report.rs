//! The answer: judged readings, named causes in the order of work, causes that the readings do not separate, looks
//! without a model, the next measurement, and quantities derived from the weights.

use super::belief::{BALANCE_PER_FRICTION, Belief, Row};
use super::bench::{friction_of_swings, sound_friction};
use super::cause::{Cause, Look, Side, causes, looks};
use super::effect::{BALANCE, FEATURES, FRICTION, N, of_known, precision};
use super::entry::{Known, at, entries, usual_range};
use super::geometry::Geometry;
use super::healthy::set_by;
use super::next::next;
use crate::balance::UNTAPPED_G;
use crate::measure::usual::usual;
use erard::Progress;

/// A cause is named if it is more likely than not.
const NAMED: f64 = 0.5;
/// A cause is named only if the readings make it more likely than any cause in whose place it would be, this many times
/// as much as their frequencies do: otherwise our estimate of frequencies decides, and not the readings.
const BY_READINGS: f64 = 3.0;
/// So many times only, where the cause's own reading is out, the other's was not taken, and the work can be undone.
const BY_OWN_READING: f64 = 1.0;
/// Two causes are in each other's place if they are together in less than this share of the cases of the rarer one.
const RIVAL: f64 = 0.35;
/// Largest number of causes named: after these, all is measured again.
const MAX_NAMED: usize = 2;
/// Causes of an undecided answer: at least this probability, and this many times as likely as before the readings.
const LEAST: f64 = 0.05;
const MORE_LIKELY: f64 = 1.5;
/// Largest number of them.
const MAX_UNDECIDED: usize = 6;
/// Friction weight from which weights are not yet those of the piano: they are taken again after easing, g.
pub const WEIGH_AGAIN_G: f64 = 16.0;
/// Place of friction in the trade's order of work.
pub(super) const FRICTION_ORDER: u32 = 1;
/// Place of leverage in the trade's order of work, before hammers and leads.
pub(super) const LEVERAGE_ORDER: u32 = 11;
/// A cure that takes other readings farther out, in precisions, than it brings in is withheld.
const WORSE: f64 = 1.0;
/// Least information of a suggested measurement, bits.
const LEAST_BITS: f64 = 0.05;

/// Place of a reading relative to its usual range.
#[derive(Debug, Clone, PartialEq)]
pub enum Standing {
    /// Inside.
    Inside,
    /// Outside by no more than the reading's error.
    Doubtful,
    /// Outside.
    Out,
    /// There is no usual range.
    NoRange,
    /// The usual range is not this key's, with the reason.
    NotJudged(&'static str),
}

/// A reading, or a quantity derived from readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Name in tables.
    pub name: &'static str,
    /// Name at the bench.
    pub label: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Value as read; `None` if the event did not happen.
    pub value: Option<f64>,
    /// Usual range at the key, with infinite values for open ends.
    pub usual: Option<[f64; 2]>,
    /// Position relative to the usual range.
    pub standing: Standing,
    /// Largest error of the value, in its unit.
    pub error: f64,
    /// Mean of the neighbours' readings in a table of keys; `None` with fewer than two.
    pub neighbours: Option<f64>,
}

impl Judged {
    /// Returns how far the reading is from the mean of its neighbours.
    #[must_use]
    pub fn off_neighbours(&self) -> Option<f64> {
        Some(self.value? - self.neighbours?)
    }

    /// Whether it is farther from them than two readings may be off.
    #[must_use]
    pub fn is_uneven(&self) -> bool {
        self.off_neighbours().is_some_and(|off| off.abs() > 2.0 * self.error + 1e-9)
    }
}

/// A cause with its probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// The cause.
    pub cause: &'static Cause,
    /// Probability, 0 to 1, under the estimates of `causes.toml`.
    pub probability: f64,
    /// Case: 1 light, 2 plain, 3 heavy.
    pub case: f64,
    /// Readings that it explains: those that it changes by more than their precision, with the estimated change.
    pub explains: Vec<(&'static str, f64)>,
    /// Reason why its cure is withheld for the present; `None` if it is not.
    pub withheld: Option<String>,
}

/// The most informative measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The reading to take, as in tables; D and U come together.
    pub name: &'static str,
    /// Name at the bench.
    pub label: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Protocol of the reading.
    pub how: &'static str,
    /// Information expected from it, bits.
    pub bits: f64,
    /// Expected value under the likeliest combinations of causes, the likeliest first.
    pub would_read: Vec<(Vec<&'static Cause>, f64)>,
}

/// The answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Diagnosis {
    /// The key, from 1.
    pub key: usize,
    /// The readings in the order of the sheet, with balance weight, friction weight and leverage derived from them.
    pub lines: Vec<Judged>,
    /// Named causes, two at most, each more likely than not, in the trade's order of work; empty if no reading is out
    /// of its range by more than its error, or if the readings decide nothing.
    pub causes: Vec<Ranked>,
    /// Causes that these readings make more likely and do not separate, the likeliest first; without work, those that
    /// it would be if doubtful readings were read again.
    pub undecided: Vec<Ranked>,
    /// Causes more likely than not whose cure is withheld for the present, with the reason.
    pub withheld: Vec<Ranked>,
    /// Causes without a model, each a sentence with its test; those of which a reading is their own sign come first.
    pub looks: Vec<&'static Look>,
    /// Whether the first look is the answer: a reading is its own sign.
    pub is_look: bool,
    /// Whether weights are taken again after friction has been eased: it is above [`WEIGH_AGAIN_G`].
    pub weigh_again: bool,
    /// Probability of every cause of the table, in its order; empty if no reading is out or doubtful.
    pub probabilities: Vec<f64>,
    /// Probability that none of the table's causes fits.
    pub something_else: f64,
    /// Reading to take next; `None` if no reading would be informative.
    pub next: Option<Suggestion>,
    /// Leverage and inertia.
    pub geometry: Geometry,
}

impl Diagnosis {
    /// Whether some reading is surely out of its range.
    #[must_use]
    pub fn is_work(&self) -> bool {
        self.lines.iter().any(|line| line.standing == Standing::Out)
    }

    /// Whether some reading is out of its range by less than it may be off.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        self.lines.iter().any(|line| line.standing == Standing::Doubtful)
    }
}

/// Diagnoses keys from their readings, in ascending order, and compares each with its neighbours. `progress` receives
/// the share done; what it returns is ignored.
pub fn diagnose_all(keys: &[(usize, Known)], progress: &mut Progress<'_>) -> Vec<Diagnosis> {
    let mut found: Vec<Diagnosis> = Vec::with_capacity(keys.len());
    for (done, (key, known)) in keys.iter().enumerate() {
        let _ = progress(done as f64 / keys.len() as f64);
        found.push(diagnose(known, *key));
    }
    super::beside::set(&mut found);
    found
}

/// Diagnoses a key from its readings.
#[must_use]
pub fn diagnose(known: &Known, key: usize) -> Diagnosis {
    let geometry = Geometry::of(known, key);
    let lines = lines(known, key, &geometry);
    let mut diagnosis = Diagnosis {
        key,
        lines,
        causes: Vec::new(),
        undecided: Vec::new(),
        withheld: Vec::new(),
        looks: Vec::new(),
        is_look: false,
        weigh_again: known.friction_g().is_some_and(|friction_g| friction_g > WEIGH_AGAIN_G),
        probabilities: Vec::new(),
        something_else: 0.0,
        next: None,
        geometry,
    };
    if !diagnosis.is_work() && !diagnosis.is_doubtful() {
        return diagnosis;
    }
    (diagnosis.looks, diagnosis.is_look) = looks_for(&diagnosis.lines);
    let follows = diagnosis.geometry.follows.iter().map(Row::following).collect();
    let belief = Belief::of(key, rows(known, key, &diagnosis.geometry), follows);
    let of = belief.of_causes();
    let mut order: Vec<usize> = (0..of.len()).collect();
    order.sort_by(|a, b| of[*b].total_cmp(&of[*a]));
    let ranked = |cause: usize| {
        let (case, change) = belief.case_and_change(cause);
        let withheld = worsens(&diagnosis.lines, &change, &[0.0; N]);
        let explains = explained(known, &change);
        Ranked { cause: &causes()[cause], probability: of[cause], case, explains, withheld }
    };
    diagnosis.probabilities.clone_from(&of);
    diagnosis.something_else = belief.of_other_and_none()[0];
    let is_told = |ranked: &Ranked| {
        let prior = ranked.cause.common / (1.0 + ranked.cause.common);
        ranked.probability >= MORE_LIKELY * prior
    };
    let is_own_line_in_range = |ranked: &Ranked| {
        let own = ranked.cause.own_line();
        diagnosis.lines.iter().any(|line| own == Some(line.name) && line.standing == Standing::Inside)
    };
    let likely = order.iter().take_while(|cause| of[**cause] >= LEAST).map(|cause| ranked(*cause));
    if !diagnosis.is_work() {
        diagnosis.undecided = likely.filter(is_told).take(MAX_UNDECIDED).collect();
        return diagnosis;
    }
    let place = |ranked: &Ranked| causes().iter().position(|own| own.key == ranked.cause.key).unwrap_or_default();
    let features = of_known(known);
    let is_known = |feature: usize| {
        let not_caught = feature == at::CHECK && known.is_not_caught;
        features[feature].is_some() || not_caught || (feature == at::HAMMER_FLANGE && known.at(at::SWINGS).is_some())
    };
    let is_unread = |cause: &Cause| {
        let geometry = &diagnosis.geometry;
        let is_derived = |feature: usize| match feature {
            at::RATIO => geometry.ratio.is_some(),
            at::FRONT if geometry.front_weight_g.is_some() => true,
            _ => geometry.follows.as_ref().is_some_and(|follows| follows.of == [feature]),
        };
        set_by(cause).is_some_and(|feature| !is_known(feature) && !is_derived(feature))
    };
    let is_own_line_out = |cause: &Cause| {
        let own = set_by(cause);
        let is_own = |line: &Judged| {
            let is_swings = own == Some(at::HAMMER_FLANGE) && line.name == entries()[at::SWINGS].name;
            is_swings || own.is_some_and(|feature| FEATURES[feature] == line.name)
        };
        diagnosis.lines.iter().any(|line| line.standing == Standing::Out && is_own(line))
    };
    // What can be undone and whose own reading is out waits for no rival whose own reading was not taken.
    let is_shown = |cause: &Cause| cause.order < LEVERAGE_ORDER && is_own_line_out(cause);
    let is_decided = |ranked: &Ranked| {
        let own = place(ranked);
        let rivals = (0..of.len()).filter(|other| *other != own && of[*other] >= LEAST);
        let mut rivals = rivals.filter(|other| belief.together(own, *other) < RIVAL * of[own].min(of[*other]));
        rivals.all(|other| {
            let [cause, rival] = [own, other].map(|at| &causes()[at]);
            let by = if is_shown(cause) && is_unread(rival) { BY_OWN_READING } else { BY_READINGS };
            of[own] / of[other] >= by * cause.common / rival.common
        })
    };
    // A screw, a hammer or leads are read before anything is done to them. Friction and leverage show elsewhere.
    let is_read = |cause: &Cause| [FRICTION_ORDER, LEVERAGE_ORDER].contains(&cause.order) || !is_unread(cause);
    let is_likely = |ranked: &Ranked| {
        let is_due = !is_own_line_in_range(ranked) && is_read(ranked.cause);
        ranked.probability >= NAMED && is_due && is_decided(ranked)
    };
    let (mut likely, others): (Vec<Ranked>, Vec<Ranked>) = likely.partition(is_likely);
    let makes_up: Vec<&str> = likely.iter().flat_map(|ranked| made_up_by(&ranked.cause.key)).copied().collect();
    for ranked in likely.iter_mut().filter(|ranked| makes_up.contains(&&*ranked.cause.key)) {
        ranked.withheld.get_or_insert_with(|| MADE_UP.to_owned());
    }
    // Leverage, hammers and leads that are likely are judged together, for all of them will be done, and one at a time.
    let changes: Vec<(&Cause, [f64; N])> = likely
        .iter()
        .filter(|ranked| ranked.cause.order >= LEVERAGE_ORDER)
        .map(|ranked| (ranked.cause, belief.case_and_change(place(ranked)).1.map(|by| by.unwrap_or(0.0))))
        .collect();
    for (own, (cause, change)) in changes.iter().enumerate() {
        let others = changes.iter().enumerate().filter(|(other, _)| *other != own);
        let others = others.fold([0.0; N], |sum, (_, (_, by))| std::array::from_fn(|i| sum[i] + by[i]));
        for ranked in likely.iter_mut().filter(|ranked| ranked.cause == *cause) {
            ranked.withheld = worsens(&diagnosis.lines, &change.map(Some), &others);
        }
    }
    let weights = likely.iter().filter(|ranked| ranked.cause.order >= LEVERAGE_ORDER);
    if let Some(first) = weights.map(|ranked| ranked.cause).min_by_key(|cause| cause.order) {
        let name = first.name.split(':').next().unwrap_or_default();
        for ranked in likely.iter_mut().filter(|ranked| ranked.cause.order > first.order) {
            ranked.withheld.get_or_insert_with(|| format!("{name} comes first, and then all weights are taken again"));
        }
    }
    let (withheld, mut named): (Vec<Ranked>, Vec<Ranked>) =
        likely.into_iter().partition(|ranked| ranked.withheld.is_some());
    diagnosis.withheld = withheld;
    let rest = named.split_off(named.len().min(MAX_NAMED));
    named.sort_by_key(|ranked| ranked.cause.order);
    diagnosis.causes = named;
    diagnosis.undecided = rest.into_iter().chain(others).filter(is_told).take(MAX_UNDECIDED).collect();
    let is_asked = is_for_causes(&diagnosis.lines, &diagnosis.looks);
    let next = Some(&belief).filter(|_| is_asked).and_then(|belief| next(belief, is_known));
    diagnosis.next = next.filter(|next| next.bits >= LEAST_BITS).map(|next| {
        let entry = &entries()[next.feature];
        let would_read = next
            .would_read
            .into_iter()
            .take(4)
            .map(|(all, value)| (all.into_iter().map(|cause| &causes()[cause]).collect(), value));
        let (name, label, how) = match next.feature {
            FRICTION => ("down_weight_g", "down-weight and up-weight (friction)", entries()[at::DOWN].how),
            _ => (entry.name, entry.label, entry.how),
        };
        Suggestion {
            name,
            label,
            unit: entry.unit,
            decimals: entry.decimals,
            how,
            bits: next.bits,
            would_read: would_read.collect(),
        }
    });
    diagnosis
}

/// Reason why regulation that makes up for a leverage is withheld.
const MADE_UP: &str = "dip and blow make up for the leverage, which comes first";

/// Regulation that makes up for a leverage: a high one gives much travel for little dip, a low one little.
fn made_up_by(cause: &str) -> &'static [&'static str] {
    match cause {
        "ratio_high" => &["dip_shallow", "hammer_low"],
        "ratio_low" => &["dip_deep", "hammer_high"],
        _ => &[],
    }
}

/// Causes without a model for the readings that are out, those whose own sign a reading is first; and whether the first
/// is one of these.
fn looks_for(lines: &[Judged]) -> (Vec<&'static Look>, bool) {
    let is_beyond = |line: &Judged| [Standing::Doubtful, Standing::Out].contains(&line.standing);
    let is_due = |look: &&Look| match look.own_sign {
        Some(_) => lines.iter().any(|line| is_beyond(line) && is_sign(line, look)),
        None => lines.iter().any(|line| line.standing == Standing::Out && is_of(line, look)),
    };
    let is_own = |look: &Look| lines.iter().any(|line| line.standing == Standing::Out && is_sign(line, look));
    let mut found: Vec<&Look> = looks().iter().filter(is_due).collect();
    found.sort_by_key(|look| !is_own(look));
    let is_first = found.first().is_some_and(|look| is_own(look));
    (found, is_first)
}

fn is_of(line: &Judged, look: &Look) -> bool {
    look.if_out.iter().any(|name| line.name == name)
}

/// Whether a reading is a sign of this cause alone: on its side of the usual range.
fn is_sign(line: &Judged, look: &Look) -> bool {
    let is_on_its_side = match (look.own_sign, line.value, line.usual) {
        (Some(Side::High), Some(value), Some([_, high])) => value > high,
        (Some(Side::Low), Some(value), Some([low, _])) => value < low,
        _ => false,
    };
    is_on_its_side && is_of(line, look)
}

/// Whether some reading that is out is one that causes of the table change, and no look's own sign: otherwise no
/// further reading tells which of them it is.
fn is_for_causes(lines: &[Judged], looks: &[&Look]) -> bool {
    let weights = [at::DOWN, at::UP, at::SWINGS].map(|index| entries()[index].name);
    let is_told = |line: &Judged| FEATURES.contains(&line.name) || weights.contains(&line.name);
    lines
        .iter()
        .any(|line| line.standing == Standing::Out && is_told(line) && !looks.iter().any(|look| is_sign(line, look)))
}

/// Reason why the cure of a cause with this effect is withheld, where `others` are undone, too: other readings would go
/// farther out than those that it brings in.
fn worsens(lines: &[Judged], change: &[Option<f64>; N], others: &[f64; N]) -> Option<String> {
    let (mut by, mut worst): (f64, Option<(f64, &Judged, f64)>) = (0.0, None);
    for (feature, name) in FEATURES.iter().enumerate() {
        let line = lines.iter().find(|line| line.name == *name).filter(|line| is_judged(line));
        let Some((line, value, [low, high], change)) = line.and_then(|line| {
            let (value, range, change) = (line.value? - others[feature], line.usual?, change[feature]?);
            Some((line, value, range, change))
        }) else {
            continue;
        };
        let out = |value: f64| (low - value).max(value - high).max(0.0) / precision(feature);
        let more = out(value - change) - out(value);
        by += more;
        if more > worst.map_or(0.0, |(most, ..)| most) {
            worst = Some((more, line, value - change));
        }
    }
    let (_, line, then) = worst.filter(|_| by > WORSE)?;
    let label = line.label.split(" (").next().unwrap_or(line.label);
    Some(format!("{label} would then be {then:.*} {}", line.decimals, line.unit).trim_end().to_owned())
}

/// Whether a line is judged by its range.
fn is_judged(line: &Judged) -> bool {
    !matches!(line.standing, Standing::NoRange | Standing::NotJudged(_))
}

/// Readings explained by a change.
fn explained(known: &Known, change: &[Option<f64>; N]) -> Vec<(&'static str, f64)> {
    let features = of_known(known);
    let mut of: Vec<(f64, &'static str, f64)> = (0..N)
        .filter(|feature| features[*feature].is_some())
        .filter_map(|feature| {
            let by = change[feature]?;
            (by.abs() > precision(feature)).then_some((by.abs() / precision(feature), FEATURES[feature], by))
        })
        .collect();
    of.sort_by(|a, b| b.0.total_cmp(&a.0));
    of.into_iter().take(4).map(|(_, name, by)| (name, by)).collect()
}

/// The readings as rows of the probability model.
fn rows(known: &Known, key: usize, geometry: &Geometry) -> Vec<Row> {
    let features = of_known(known);
    // Where the ratio follows from the weights, it is the reading, and the front weight has said what it can.
    let derived = geometry.ratio.filter(|_| known.at(at::RATIO).is_none());
    let mut rows: Vec<Row> = (0..N)
        .filter(|feature| *feature < 2 || entries()[*feature].not_judged(key).is_none())
        .filter(|feature| *feature != at::FRONT || derived.is_none())
        .filter_map(|feature| {
            // Springs and magnets take their part of what leads do.
            let assist_g = if feature == at::FRONT { known.assist_g() } else { 0.0 };
            let range = sound_range(feature, key).filter(|_| assist_g == 0.0);
            Some(Row::of(feature, features[feature]? + assist_g).within(range))
        })
        .collect();
    if known.is_untapped {
        rows.iter_mut().filter(|row| row.of[0].0 == FRICTION).for_each(|row| row.error = row.error.hypot(UNTAPPED_G));
    }
    if let Some(ratio) = derived {
        rows.push(Row::of_band(vec![(at::RATIO, 1.0)], ratio, sound_range(at::RATIO, key)));
    }
    match (known.at(at::DOWN), known.at(at::UP)) {
        (Some(down), None) => {
            let range = entries()[at::DOWN].range(key);
            rows.push(Row { of: vec![(BALANCE, 1.0), (FRICTION, 1.0)], value: down, error: 0.6, range });
        }
        (None, Some(up)) => {
            let range = entries()[at::UP].range(key);
            rows.push(Row { of: vec![(BALANCE, 1.0), (FRICTION, -1.0)], value: up, error: 0.6, range });
        }
        _ => {}
    }
    if known.is_not_caught {
        rows.push(Row::not_caught());
    }
    let is_natural = entries()[at::FRONT].not_judged(key).is_none();
    if let (None, None, Some(front), true) = (derived, known.at(at::FRONT), geometry.front_weight_g, is_natural) {
        let error = (front.high - front.low) / libm::sqrt(12.0);
        let value = 0.5 * (front.low + front.high);
        rows.push(Row { of: vec![(at::FRONT, 1.0)], value, error, range: None });
    }
    if let (None, Some(swings)) = (known.at(at::HAMMER_FLANGE), known.at(at::SWINGS)) {
        let strike_g = known.at(at::STRIKE).unwrap_or_else(|| {
            let [low, high] = usual("strike_weight_g").map_or([None; 2], |range| range.at(key));
            0.5 * (low.unwrap_or(8.0) + high.unwrap_or(10.0))
        });
        let [low, high] = friction_of_swings(swings, strike_g);
        let error = (high - low) / libm::sqrt(12.0);
        let value = 0.5 * (low + high);
        // The usual swings go with the count, and not a gauge's usual grams: the pendulum agrees with them roughly.
        let range = entries()[at::SWINGS].range(key).and_then(|usual| sound_friction(usual, strike_g));
        rows.push(Row { of: vec![(at::HAMMER_FLANGE, 1.0)], value, error, range });
    }
    rows
}

/// Range in which a feature of a sound key lies; `None` without one.
fn sound_range(feature: usize, key: usize) -> Option<[f64; 2]> {
    match feature {
        BALANCE | FRICTION => usual_range(FEATURES[feature], key),
        _ => entries()[feature].range(key),
    }
}

fn lines(known: &Known, key: usize, geometry: &Geometry) -> Vec<Judged> {
    let mut lines = Vec::new();
    for (index, entry) in entries().iter().enumerate() {
        let not_there = index == at::CHECK && known.is_not_caught;
        let value = known.at(index);
        if value.is_some() || not_there {
            let usual = entry.range(key);
            // Down-weight and up-weight follow from balance weight and friction weight, which are judged.
            let follows = [at::DOWN, at::UP].contains(&index) && known.balance_g().is_some();
            let standing = match (entry.not_judged(key), usual, value) {
                (Some(why), ..) => Standing::NotJudged(why),
                (None, None, _) => Standing::NoRange,
                (None, Some(_), _) if follows => Standing::NoRange,
                (None, Some(_), None) => Standing::Out,
                (None, Some(range), Some(value)) => stands(value, range, entry.precision, entry.decimals),
            };
            let usual = usual.filter(|_| !follows);
            let (name, label, unit, decimals) = (entry.name, entry.label, entry.unit, entry.decimals);
            let error = entry.precision;
            lines.push(Judged { name, label, unit, decimals, value, usual, standing, error, neighbours: None });
        }
        if index == at::UP {
            // Friction shifts the balance weight a little: above the usual it is known so well only.
            let friction_g = known.friction_g().filter(|friction_g| *friction_g > WEIGH_AGAIN_G);
            let untapped_g = if known.is_untapped { UNTAPPED_G } else { 0.0 };
            let shifted_g = friction_g.map_or(0.0, |friction_g| BALANCE_PER_FRICTION * (friction_g - EASED_G));
            for (name, label, value, error) in [
                ("balance_weight_g", "balance weight (D+U)/2", known.balance_g(), 1.0 + shifted_g),
                ("friction_weight_g", "friction weight (D-U)/2", known.friction_g(), 1.0 + untapped_g),
            ] {
                let usual = usual_range(name, key);
                if let (Some(value), Some(range)) = (value, usual) {
                    let standing = stands(value, range, error, 1);
                    lines.push(Judged {
                        name,
                        label,
                        unit: "g",
                        decimals: 1,
                        value: Some(value),
                        usual,
                        standing,
                        error,
                        neighbours: None,
                    });
                }
            }
        }
        if let (at::RATIO, Some(follows)) = (index, &geometry.follows) {
            let (middle, error) = follows.value.middle_and_error();
            lines.push(Judged {
                name: follows.name(),
                label: follows.label,
                unit: "g",
                decimals: 1,
                value: Some(middle),
                usual: Some(follows.usual),
                standing: stands(middle, follows.usual, error, 1),
                error,
                neighbours: None,
            });
        }
        if let (at::RATIO, None, Some(ratio)) = (index, value, geometry.ratio) {
            let usual = entry.range(key);
            let (middle, error) = ratio.middle_and_error();
            let standing = match (entry.not_judged(key), usual) {
                (Some(why), _) => Standing::NotJudged(why),
                (None, Some(range)) => stands(middle, range, error, entry.decimals),
                (None, None) => Standing::NoRange,
            };
            let label = "leverage R by the equation of balance";
            lines.push(Judged {
                name: entry.name,
                label,
                unit: "",
                decimals: 2,
                value: Some(middle),
                usual,
                standing,
                error,
                neighbours: None,
            });
        }
    }
    lines
}

/// Friction weight of an eased key, g: the middle of the usual range of middle C.
const EASED_G: f64 = 11.0;

/// Place of a reading relative to its range, both as rounded for display.
fn stands(value: f64, [low, high]: [f64; 2], precision: f64, decimals: usize) -> Standing {
    let scale = libm::pow(10.0, decimals as f64);
    let read = |x: f64| if x.is_finite() { (x * scale).round() / scale } else { x };
    let beyond = (read(low) - read(value)).max(read(value) - read(high));
    if beyond <= 0.0 {
        Standing::Inside
    } else if beyond <= precision + 1e-9 {
        Standing::Doubtful
    } else {
        Standing::Out
    }
}
