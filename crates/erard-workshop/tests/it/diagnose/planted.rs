//! Pianos with planted causes as true readings, `tests/planted.csv`: they were simulated once, so that the ranking is
//! tested on them in seconds. `.ci/regenerate planted` simulates them anew.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use erard::instrument::Instrument;
use erard_workshop::balance::KeyModel;
use erard_workshop::diagnose::{Diagnosis, Known, causes, diagnose, entries};
use erard_workshop::distances::Protocol;
use erard_workshop::regulate::{Goal, regulate};
use erard_workshop::worklist::Work;

use super::proof::{KEY, dealt, on_all_cores, planted, read_within, sound_samples};
use crate::worklist::hand::Chance;

const FILE: &str = include_str!("../../planted.csv");

/// A piano: what was planted, and its true readings.
#[derive(Debug, Clone)]
pub struct Truth {
    /// `fault`: one cause on a drawn grand; `sound`: a drawn grand; `other`: one cause on another instrument; `kind`:
    /// an instrument with a ratio and a strike weight, regulated and leaded.
    pub set: String,
    /// The instrument.
    pub grand: String,
    /// The planted cause, or what was made of the instrument.
    pub planted: String,
    pub known: Known,
}

impl Truth {
    fn row(&self) -> String {
        let mut row = format!("{},{},{}", self.set, self.grand, self.planted);
        for entry in entries() {
            let value = self.known.get(entry.name).map_or(String::new(), |value| format!("{value:.4}"));
            let is_none = entry.name == "check_mm" && self.known.is_not_caught;
            let _ = write!(row, ",{}", if is_none { "none" } else { &value });
        }
        row
    }
}

fn header() -> String {
    entries().iter().fold("set,grand,planted".to_owned(), |header, entry| header + "," + entry.name)
}

/// The file's pianos.
pub fn truths() -> Vec<Truth> {
    parse(FILE)
}

pub fn parse(text: &str) -> Vec<Truth> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(&*header()));
    let of = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let mut known = Known::default();
        for (entry, cell) in entries().iter().zip(&cells[3..]) {
            match *cell {
                "none" => known.is_not_caught = true,
                cell => known.set(entry.name, cell.parse().ok()),
            }
        }
        let [set, grand, planted] = [0, 1, 2].map(|at| cells[at].to_owned());
        Truth { set, grand, planted, known }
    };
    lines.map(of).collect()
}

/// Faults on drawn grands, and how many of these; they are read when sound, too.
const FAULTS: usize = 60;
const GRANDS: usize = 8;
/// Ratios and strike weights that are planted together, the latter on strike-weight curves 2, 7 and 12 at middle C.
const RATIOS: [f64; 4] = [4.8, 5.6, 6.6, 7.8];
const STRIKES_G: [f64; 3] = [7.0, 9.5, 12.0];
/// Balance weight to which keys are leaded, g, and front weights that keys bear.
const LEADED_TO_G: f64 = 38.0;
const FRONTS_G: [f64; 2] = [0.0, 45.0];
const OTHER: &str = "steinway-o";

/// Simulates the file.
pub fn simulate() -> String {
    type Job<'a> = Box<dyn Fn() -> Option<Truth> + Sync + 'a>;
    let grands = sound_samples(GRANDS, 5001);
    let other = Instrument::builtin(OTHER).unwrap();
    let mut jobs: Vec<Job<'_>> = Vec::new();
    for at in 0..FAULTS {
        let (number, grand, cause) = dealt(&grands, FAULTS, 0, at);
        jobs.push(Box::new(move || {
            let of = planted(at, number, grand, cause);
            Some(truth("fault", &format!("sample {number}"), &causes()[cause?].key, of.truth))
        }));
    }
    for (number, grand) in &grands {
        jobs.push(Box::new(move || {
            let known = Known::measured(grand, &mut |_| true).unwrap();
            Some(truth("sound", &format!("sample {number}"), "", known))
        }));
    }
    for at in 0..causes().len() {
        let other = &other;
        jobs.push(Box::new(move || {
            Some(truth("other", OTHER, &causes()[at].key, planted(at, 1, other, Some(at)).truth))
        }));
    }
    let known = Known::measured(&other, &mut |_| true).unwrap();
    let band = diagnose(&known, KEY).geometry.ratio.unwrap();
    let own = 0.5 * (band.low + band.high);
    for (ratio, strike_g) in RATIOS.iter().flat_map(|ratio| STRIKES_G.map(|strike_g| (*ratio, strike_g))) {
        let other = &other;
        jobs.push(Box::new(move || {
            let known = kind(other, ratio / own, strike_g)?;
            Some(truth("kind", OTHER, &format!("ratio {ratio} strike weight {strike_g}"), known))
        }));
    }
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    on_all_cores(|| {
        while let Some((at, job)) = Some(next.fetch_add(1, Ordering::SeqCst)).and_then(|at| Some((at, jobs.get(at)?))) {
            if let Some(truth) = job() {
                println!("{}", truth.row());
                found.lock().unwrap().insert(at, truth.row());
            }
        }
    });
    let rows: Vec<String> = std::iter::once(header()).chain(found.into_inner().unwrap().into_values()).collect();
    rows.join("\n") + "\n"
}

fn truth(set: &str, grand: &str, planted: &str, known: Known) -> Truth {
    let [set, grand, planted] = [set, grand, planted].map(str::to_owned);
    Truth { set, grand, planted, known }
}

/// An instrument whose ratio is changed by a factor at the capstan line and whose hammer has a strike weight,
/// regulated, and leaded to a balance weight as far as its key bears; `None` if it cannot be regulated.
fn kind(grand: &Instrument, factor: f64, strike_g: f64) -> Option<Known> {
    let go_on = &mut |_: f64| true;
    let model = KeyModel::of(grand).unwrap();
    let (c, h) = (model.capstan_mm, model.heel_mm);
    let mut made = grand.clone();
    Work::Capstan { by_mm: c * h * (1.0 - factor) / (h + factor * c) }.carry_out(&mut made, go_on).unwrap();
    Work::Hammer { by_g: strike_g - model.strike_weight_g }.carry_out(&mut made, go_on).unwrap();
    let regulated = regulate(&made, &Goal::norms(), &Protocol::default(), &mut |_| true).ok()?;
    if !regulated.all_met() {
        return None;
    }
    let mut known = Known::measured(&regulated.instrument, go_on).ok()?;
    let (balance_g, front_g) = (known.balance_g()?, known.get("front_weight_g")?);
    let by_g = (front_g + balance_g - LEADED_TO_G).clamp(FRONTS_G[0], FRONTS_G[1]) - front_g;
    for (name, sign) in [("front_weight_g", 1.0), ("down_weight_g", -1.0), ("up_weight_g", -1.0)] {
        known.set(name, known.get(name).map(|own| own + sign * by_g));
    }
    Some(known)
}

/// Errors of a bench: 1.5 g of D and U, 0.1 g of SW, 0.5 g of FW, 0.2 mm of dip, blow and let-off.
pub fn bench_error(name: &str, precision: f64) -> f64 {
    match name {
        "down_weight_g" | "up_weight_g" => 1.5,
        "dip_mm" | "blow_mm" | "let_off_mm" => 0.2,
        _ => precision,
    }
}

/// Bench tests, taken on request only.
pub const ASKED: [&str; 3] = ["key_alone_friction_g", "hammer_flange_g", "whippen_flange_g"];
/// Least probability that counts: a cause that the answer left out has it.
const LEAST: f64 = 0.01;

/// A diagnosis of a truth as it is read, and what it says of what was planted.
pub struct Told {
    pub truth: Truth,
    pub found: Diagnosis,
    /// Probability of the planted cause.
    pub planted: f64,
    /// The likeliest cause and its probability.
    pub first: (&'static str, f64),
}

/// Diagnoses the truths of a set as they are read, each off by up to an error, without the tests that are taken on
/// request.
pub fn told(set: &str, error: fn(&str, f64) -> f64) -> Vec<Told> {
    let of = |(at, truth): (usize, Truth)| {
        let mut known = read_within(&truth.known, error, &mut Chance::new(7000 + at as u64));
        ASKED.iter().for_each(|name| known.set(name, None));
        let found = diagnose(&known, KEY);
        let of = |at: usize| found.probabilities.get(at).copied().unwrap_or(0.0);
        let planted = causes().iter().position(|cause| cause.key == truth.planted).map_or(0.0, of);
        let first = (0..causes().len()).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap();
        let first = (&*causes()[first].key, of(first));
        Told { truth, found, planted, first }
    };
    truths().into_iter().filter(|truth| truth.set == set).enumerate().map(of).collect()
}

/// Mean logarithm of the probability of what was planted.
pub fn log_score(told: &[Told]) -> f64 {
    told.iter().map(|one| one.planted.clamp(LEAST, 1.0).ln()).sum::<f64>() / told.len() as f64
}

/// Wilson's 95 % interval of a share.
pub fn interval(hits: usize, of: usize) -> [f64; 2] {
    interval_of(hits, of, 1.96)
}

/// Wilson's interval of a share, `z` standard deviations to either side.
pub fn interval_of(hits: usize, of: usize, z: f64) -> [f64; 2] {
    let (n, p) = (of as f64, hits as f64 / of as f64);
    let (middle, half) = (p + z * z / (2.0 * n), z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt());
    [middle - half, middle + half].map(|end| end / (1.0 + z * z / n))
}

/// A table of what was told: planted, its probability, the likeliest, what is named.
pub fn report(told: &[Told]) -> String {
    told.iter().fold(String::new(), |mut text, one| {
        let named: Vec<&str> = one.found.causes.iter().map(|ranked| &*ranked.cause.key).collect();
        let (first, p) = one.first;
        let _ = writeln!(
            text,
            "  {:14} {:34} {:.3}  first {first} {p:.2}  named {}",
            one.truth.grand,
            one.truth.planted,
            one.planted,
            named.join(" ")
        );
        text
    })
}
