//! Answer in sentences, and as JSON: the same for every front.

use erard::keyboard::{KEYS, note_name};
use serde_json::{Value, json};

use super::cause::{Cause, Look};
use super::entry::{Entry, Impossible, entries, readings};
use super::geometry::Band;
use crate::worklist::SECTION_ENDS;

use super::report::{Diagnosis, FRICTION_ORDER, Judged, LEVERAGE_ORDER, Ranked, Standing, Suggestion, WEIGH_AGAIN_G};

/// Number of looks on a page.
const LOOKS: usize = 2;

/// Basis of every answer, a sentence.
pub const BASIS: &str = "What a cause does to each reading is simulated on grands around the built-in concert-grand, not on your piano; how \
     common each cause is, is an estimate. Probabilities are no better than these.";

/// Joins the causes of a combination.
#[must_use]
pub fn joined(causes: &[&Cause]) -> String {
    match causes {
        [] => "none of these".to_owned(),
        causes => causes.iter().map(|cause| cause.name.as_str()).collect::<Vec<_>>().join(" + "),
    }
}

/// Returns the label, unit and decimals with which a feature of [`Ranked::explains`] is shown.
#[must_use]
pub fn explained_as(name: &'static str) -> (&'static str, &'static str, usize) {
    match name {
        "balance_weight_g" => ("balance weight", "g", 0),
        "friction_weight_g" => ("friction weight", "g", 0),
        _ => {
            let entry = entries().iter().find(|entry| entry.name == name);
            entry.map_or((name, "", 1), |entry| (entry.label, entry.unit, entry.decimals))
        }
    }
}

impl Diagnosis {
    /// Returns the verdict in a sentence.
    #[must_use]
    pub fn verdict(&self) -> String {
        if !self.is_work() {
            let again = if self.is_doubtful() { " Take those marked ? again." } else { "" };
            let causes = self.undecided.iter().map(|ranked| ranked.cause.name.as_str());
            let names: Vec<&str> = causes.chain(self.looks.iter().map(|look| look.name.as_str())).collect();
            let then = match &names[..] {
                [] => String::new(),
                names => format!(" If they read the same, it may be: {}.", names.join("; ")),
            };
            return format!(
                "No reading is out of its usual range by more than it may be off: no work.{again}{then} What was not measured was not judged."
            );
        }
        match (self.looks.first().filter(|_| self.is_look), &self.causes[..]) {
            (Some(look), []) => format!("A sign of its own: {}", look.name),
            (_, []) => self.open_question().unwrap_or_else(|| {
                let names: Vec<&str> = self.looks.iter().map(|look| look.name.as_str()).collect();
                let waits = |ranked: &Ranked| {
                    format!("{} ({})", ranked.cause.name, ranked.withheld.as_deref().unwrap_or_default())
                };
                let waits: Vec<String> = self.withheld.iter().map(waits).collect();
                match &names[..] {
                    _ if !waits.is_empty() => format!("More likely than not, but not yet to do: {}", waits.join("; ")),
                    [] => "These readings point to no cause of the list".to_owned(),
                    names => {
                        format!("These readings point to no cause that is simulated; look for: {}", names.join("; "))
                    }
                }
            }),
            (_, [_]) => "The cause that is more likely than not".to_owned(),
            (_, [..]) => "The causes that are more likely than not, in the order of work".to_owned(),
        }
    }

    /// Returns the sentence on causes that the readings do not separate; `None` if there are none.
    #[must_use]
    pub fn open_question(&self) -> Option<String> {
        if !self.is_work() {
            return None;
        }
        let names: Vec<&str> = self.undecided.iter().map(|ranked| ranked.cause.name.as_str()).collect();
        let (last, others) = names.split_last()?;
        Some(match others {
            [] => format!("These readings do not decide whether it is: {last}"),
            others => format!("These readings decide nothing among: {}; {last}", others.join("; ")),
        })
    }

    /// What comes first where a cause changes weights, which are then weighed again: easing above [`WEIGH_AGAIN_G`] of
    /// friction, or the regulation that is named; `None` for friction and regulation themselves.
    #[must_use]
    pub fn weigh_first(&self, ranked: &Ranked) -> Option<&'static str> {
        let is_regulation = |one: &Ranked| one.cause.order > FRICTION_ORDER && one.cause.order < LEVERAGE_ORDER;
        let is_late = ranked.cause.order >= LEVERAGE_ORDER;
        match (self.weigh_again, self.causes.iter().any(is_regulation)) {
            (true, _) if is_late => Some("after easing"),
            (false, true) if is_late => Some("after regulating"),
            _ => None,
        }
    }

    /// Returns the work in order: doubtful readings, looks of ten seconds, the named causes in the trade's order, the
    /// reading that decides among others, and all readings again. Friction that is to be eased before the weights are
    /// those of the piano comes before all other causes, with the reading that decides where it rubs.
    #[must_use]
    pub fn to_do(&self) -> Vec<String> {
        if !self.is_work() {
            return Vec::new();
        }
        let mut lines = Vec::new();
        let doubtful = self.lines.iter().filter(|line| line.standing == Standing::Doubtful);
        let doubtful: Vec<&str> = doubtful.map(|line| line.label).collect();
        if !doubtful.is_empty() {
            lines.push(format!("Take again what may be read wrong: {}.", doubtful.join(", ")));
        }
        lines.extend(self.looks.iter().take(LOOKS).map(|look| {
            let then = if self.is_look { format!(" Then {}.", look.cure) } else { String::new() };
            format!("Look for {}: {}.{then}", look.name, look.test)
        }));
        let test = |ranked: &Ranked| {
            let again = self.weigh_first(ranked).map_or(String::new(), |after| format!(" Weigh again {after} first."));
            let Cause { name, test, cure, .. } = ranked.cause;
            format!("Test for {name}: {test}. If it is so, {cure}.{again}")
        };
        let (friction, later): (Vec<&Ranked>, Vec<&Ranked>) =
            self.causes.iter().partition(|ranked| ranked.cause.order == FRICTION_ORDER);
        lines.extend(friction.into_iter().map(test));
        // The question itself is no work: it has its own heading.
        let mut to_decide: Vec<String> = self
            .next
            .as_ref()
            .map(|next| format!("Measure {} ({}) and enter it.", next.label, next.how))
            .or_else(|| self.open_question().map(|question| format!("{question}.")))
            .into_iter()
            .collect();
        if self.weigh_again {
            lines.append(&mut to_decide);
            lines.push(format!(
                "Ease friction and weigh again before leverage, hammers and leads: it is over {WEIGH_AGAIN_G:.0} g."
            ));
        }
        lines.extend(later.into_iter().map(test));
        for ranked in &self.withheld {
            let why = ranked.withheld.as_deref().unwrap_or_default();
            lines.push(format!("Not yet for {}: {why}.", ranked.cause.name));
        }
        lines.append(&mut to_decide);
        lines.push("Take all readings again: what is still out has another cause.".to_owned());
        lines
    }

    /// Reason why some reading is not judged; `None` if all are.
    #[must_use]
    pub fn not_judged(&self) -> Option<&'static str> {
        self.lines.iter().find_map(|line| match line.standing {
            Standing::NotJudged(why) => Some(why),
            _ => None,
        })
    }
}

/// Cause that is named at most of the keys with work of a piano, or of a section: it is one, and looked for once.
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// The cause.
    pub cause: &'static Cause,
    /// Keys at which it is named.
    pub keys: Vec<usize>,
    /// Number of keys with work, of the piano or the section.
    pub of: usize,
    /// First and last key of the section; `None` for a cause of the whole piano.
    pub section: Option<[usize; 2]>,
}

/// Fewest keys of a common cause.
const COMMON_KEYS: usize = 3;

/// Returns the causes that are named at three keys and at half of those with work: of the piano, or else of its
/// sections, which end at `section_ends`, the highest excepted.
#[must_use]
pub fn common(found: &[Diagnosis], section_ends: &[usize]) -> Vec<Common> {
    let starts = std::iter::once(1).chain(section_ends.iter().map(|end| end + 1));
    let sections: Vec<[usize; 2]> =
        starts.zip(section_ends.iter().copied().chain([KEYS])).map(|(from, to)| [from, to]).collect();
    let whole = common_of(found, None).filter(|whole| {
        // A cause of the whole piano is named in each of its sections with some work.
        sections.iter().all(|[from, to]| {
            let is_in = |key: &usize| (from..=to).contains(&key);
            let work = found.iter().filter(|one| one.is_work() && is_in(&one.key)).count();
            work < COMMON_KEYS || whole.keys.iter().any(is_in)
        })
    });
    match whole {
        Some(whole) => vec![whole],
        None => sections.into_iter().filter_map(|section| common_of(found, Some(section))).collect(),
    }
}

fn common_of(found: &[Diagnosis], section: Option<[usize; 2]>) -> Option<Common> {
    let is_in = |one: &&Diagnosis| section.is_none_or(|[from, to]| (from..=to).contains(&one.key));
    let found: Vec<&Diagnosis> = found.iter().filter(is_in).filter(|one| one.is_work()).collect();
    let at = |cause: &'static Cause| -> Vec<usize> {
        let named = |one: &&&Diagnosis| one.causes.iter().any(|ranked| ranked.cause == cause);
        found.iter().filter(named).map(|one| one.key).collect()
    };
    let most = super::cause::causes().iter().map(|cause| (cause, at(cause))).max_by_key(|(_, keys)| keys.len());
    let (cause, keys) = most.filter(|(_, keys)| keys.len() >= COMMON_KEYS && 2 * keys.len() >= found.len())?;
    Some(Common { cause, keys, of: found.len(), section })
}

impl Common {
    /// Returns the sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Common { cause, keys, of, section } = self;
        let place =
            section.map_or(String::new(), |[from, to]| format!(" from {} to {}", note_name(from), note_name(to)));
        format!(
            "{} of {of} keys with work{place} say the same, so that the cause is one: {}. {}",
            keys.len(),
            cause.name,
            "Mend it on sample keys first, then measure all keys again."
        )
    }
}

/// Returns the answers as JSON for programs and pages: `diagnosis.json`. `readings_from` is the file of the readings;
/// `is_key_assumed` states that no key was given, so that the usual ranges of an assumed key are used.
#[must_use]
pub fn answer(found: &[Diagnosis], readings_from: Option<&str>, is_key_assumed: bool) -> Value {
    json!({
        "readings_from": readings_from,
        "is_key_assumed": is_key_assumed,
        "rests_on": BASIS,
        "common": common(found, &SECTION_ENDS).iter().map(of_common).collect::<Vec<_>>(),
        "keys": found.iter().map(of_key).collect::<Vec<_>>(),
    })
}

fn of_common(one: &Common) -> Value {
    json!({
        "cause": one.cause.key,
        "name": one.cause.name,
        "keys": one.keys,
        "of": one.of,
        "section": one.section,
    })
}

fn of_key(one: &Diagnosis) -> Value {
    let ends = |band: Option<Band>| band.map(|band| json!({"low": rounded(band.low), "high": rounded(band.high)}));
    json!({
        "key": one.key,
        "note": note_name(one.key),
        "readings": one.lines.iter().map(of_line).collect::<Vec<_>>(),
        "is_work": one.is_work(),
        "verdict": one.verdict(),
        "causes": one.causes.iter().map(of_cause).collect::<Vec<_>>(),
        "undecided": one.undecided.iter().map(of_cause).collect::<Vec<_>>(),
        "withheld": one.withheld.iter().map(of_cause).collect::<Vec<_>>(),
        "looks": one.looks.iter().map(of_look).collect::<Vec<_>>(),
        "open_question": one.open_question(),
        "weigh_again": one.weigh_again,
        "something_else": rounded(one.something_else),
        "to_do": one.to_do(),
        "measure_next": one.next.as_ref().map(of_next),
        "leverage": ends(one.geometry.ratio),
        "front_weight_g": ends(one.geometry.front_weight_g),
        "inertia_kg": ends(one.geometry.inertia_kg),
        "notes": one.geometry.notes,
    })
}

fn of_line(line: &Judged) -> Value {
    let end = |x: f64| if x.is_finite() { Value::from(x) } else { Value::Null };
    let (standing, why) = match line.standing {
        Standing::Inside => ("inside", None),
        Standing::Doubtful => ("doubtful", None),
        Standing::Out => ("out", None),
        Standing::NoRange => ("no_range", None),
        Standing::NotJudged(why) => ("not_judged", Some(why)),
    };
    json!({
        "name": line.name,
        "label": line.label,
        "value": line.value.map(rounded),
        "unit": line.unit,
        "decimals": line.decimals,
        "usual_low": line.usual.map_or(Value::Null, |[low, _]| end(low)),
        "usual_high": line.usual.map_or(Value::Null, |[_, high]| end(high)),
        "standing": standing,
        "neighbours": line.neighbours.map(rounded),
        "likely_reason": why,
    })
}

fn of_look(look: &&Look) -> Value {
    json!({"cause": look.key, "name": look.name, "test": look.test, "cure": look.cure})
}

fn of_cause(ranked: &Ranked) -> Value {
    let explains = ranked.explains.iter().map(|(name, by)| {
        let (label, unit, decimals) = explained_as(name);
        json!({"name": name, "label": label, "by": rounded(*by), "unit": unit, "decimals": decimals})
    });
    json!({
        "cause": ranked.cause.key,
        "name": ranked.cause.name,
        "probability": rounded(ranked.probability),
        "case": rounded(ranked.case),
        "explains": explains.collect::<Vec<_>>(),
        "test": ranked.cause.test,
        "cure": ranked.cause.cure,
        "odds_assumed": ranked.cause.common,
        "withheld_because": ranked.withheld,
    })
}

fn of_next(next: &Suggestion) -> Value {
    let told = |(causes, value): &(Vec<&'static Cause>, f64)| {
        let keys: Vec<&str> = causes.iter().map(|cause| cause.key.as_str()).collect();
        json!({"value": rounded(*value), "causes": keys, "names": joined(causes)})
    };
    json!({
        "name": next.name,
        "label": next.label,
        "unit": next.unit,
        "decimals": next.decimals,
        "how": next.how,
        "bits": rounded(next.bits),
        "would_read": next.would_read.iter().map(told).collect::<Vec<_>>(),
    })
}

/// Rounds to a thousandth.
fn rounded(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

/// Returns the entries that can be measured, for a form: each with its label, its unit, its possible range, its usual
/// range at a key (null where open, without a usual range, or where the range does not apply to this key), and how to
/// measure it.
#[must_use]
pub fn form(key: usize) -> Value {
    let of = |entry: &Entry| {
        let end = |x: f64| x.is_finite().then_some(x);
        let usual = entry.range(key).filter(|_| entry.not_judged(key).is_none());
        json!({
            "name": entry.name,
            "label": entry.label,
            "unit": entry.unit,
            "decimals": entry.decimals,
            "limits": entry.limits,
            "precision": entry.precision,
            "usual": usual.map_or([None; 2], |[low, high]| [end(low), end(high)]),
            "how": entry.how,
        })
    };
    readings().map(of).collect()
}

/// Returns the errors of typed readings, for a form: each with the `name` of its entry (`key`, `leads`; empty if it
/// belongs to none), what was `found` and what is `expected`.
#[must_use]
pub fn faults(all: &[Impossible]) -> Value {
    all.iter().map(|one| json!({"name": one.entry, "found": one.what, "expected": one.expected})).collect()
}
