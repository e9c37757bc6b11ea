//! Pianos with planted causes as true readings, `tests/planted.csv`: they were simulated once, so that the ranking is
//! tested on them in seconds. `.ci/regenerate planted` simulates them anew.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

use erard::instrument::Instrument;
use erard_workshop::balance::KeyModel;
use erard_workshop::diagnose::{Cause, Diagnosis, Known, causes, diagnose, entries, injected_amount};
use erard_workshop::distances::Protocol;
use erard_workshop::regulate::{Goal, regulate};
use erard_workshop::worklist::Work;

use super::proof::{GRAND, KEY, dealt, on_all_cores, planted, read_within, sound_samples, with};
use crate::worklist::hand::Chance;

const FILE: &str = include_str!("../../planted.csv");

/// A piano: what was planted, and its true readings.
#[derive(Debug, Clone)]
pub struct Truth {
    /// `fault`: one cause on a drawn grand; `sound`: a drawn grand; `other`: one cause on another instrument;
    /// `largest`: one cause beyond its heavy case; `kind`: an instrument with a ratio and a strike weight, regulated
    /// and leaded; `refused`: such an instrument that cannot be regulated, without readings.
    pub set: String,
    /// The instrument.
    pub grand: String,
    /// The planted cause, or what was made of the instrument.
    pub planted: String,
    pub known: Known,
}

impl Truth {
    /// Planted causes: of a kind those of leverage and hammer that are out of their ranges.
    pub fn causes(&self) -> Vec<&'static str> {
        let is_of = |cause: &str| match (&*self.set, cause) {
            ("kind", "ratio_high") => self.beyond("strike_weight_ratio") > 0.0,
            ("kind", "ratio_low") => self.beyond("strike_weight_ratio") < 0.0,
            ("kind", "hammer_heavy") => self.beyond("strike_weight_g") > 0.0,
            ("kind", "hammer_light") => self.beyond("strike_weight_g") < 0.0,
            (set, cause) => set != "kind" && cause == self.planted,
        };
        causes().iter().map(|cause| &*cause.key).filter(|cause| is_of(cause)).collect()
    }

    /// How far a true reading is beyond its range, above it positive; 0 inside.
    pub fn beyond(&self, name: &str) -> f64 {
        let found = diagnose(&self.known, KEY);
        let line = found.lines.iter().find(|line| line.name == name).unwrap();
        let (value, [low, high]) = (line.value.unwrap(), line.usual.unwrap());
        (value - high).max(0.0) - (low - value).max(0.0)
    }

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
/// Pianos of another make, on which every cause is planted once: the file, and as many drawn from it.
const OTHER: &str = "steinway-o";
const OTHER_GRANDS: usize = 1;
/// A piano that is put right first.
const SPOILED: &str = "heavy-touch";
/// Ratios that are planted in turn with the strike weights, other ones on each piano.
const RATIOS: [f64; 5] = [4.8, 5.6, 6.4, 7.2, 8.0];
/// Strike weights of curves 1 to 13 at middle C, g: the first, and the step from curve to curve.
const CURVES: usize = 13;
const CURVE_1_G: f64 = 6.5;
const CURVE_STEP_G: f64 = 0.5;
/// The ratio and the strike weight of a piano that is put right.
const RIGHT: (f64, f64) = (5.6, 9.5);
/// Balance weight to which keys are leaded, g, and front weights that keys bear.
const LEADED_TO_G: f64 = 38.0;
const FRONTS_G: [f64; 2] = [0.0, 45.0];
/// First number of the drawn grands.
const FROM: u32 = 5001;

/// A sound piano.
struct Sound {
    name: String,
    number: u32,
    instrument: Instrument,
}

/// Simulates the file.
pub fn simulate() -> String {
    type Job<'a> = Box<dyn Fn() -> Truth + Sync + 'a>;
    let drawn = sound_samples(GRAND, GRANDS, FROM);
    let [other, spoiled] = [OTHER, SPOILED].map(|name| Instrument::builtin(name).unwrap());
    let sample = |name: &str, (number, instrument): (u32, Instrument)| {
        let name = if name == GRAND { format!("sample {number}") } else { format!("{name} sample {number}") };
        Sound { name, number, instrument }
    };
    let right = kind(&spoiled, RIGHT).expect("it is put right").0;
    let spoiled = Sound { name: SPOILED.to_owned(), number: 2, instrument: spoiled };
    let mut others = vec![Sound { name: OTHER.to_owned(), number: 1, instrument: other }];
    others.extend(sound_samples(OTHER, OTHER_GRANDS, FROM).into_iter().map(|one| sample(OTHER, one)));
    others.push(Sound { name: format!("{SPOILED} put right"), number: 2, instrument: right });
    let first = sample(GRAND, drawn[0].clone());
    let mut jobs: Vec<Job<'_>> = Vec::new();
    for at in 0..FAULTS {
        let (number, grand, cause) = dealt(&drawn, FAULTS, 0, at);
        jobs.push(Box::new(move || {
            let of = planted(at, number, grand, cause);
            truth("fault", &format!("sample {number}"), cause.map_or("", |at| &causes()[at].key), of.truth)
        }));
    }
    for (number, grand) in &drawn {
        jobs.push(Box::new(move || {
            let known = Known::measured(grand, &mut |_| true).unwrap();
            truth("sound", &format!("sample {number}"), "", known)
        }));
    }
    for (sound, at) in others.iter().flat_map(|sound| (0..causes().len()).map(move |at| (sound, at))) {
        jobs.push(Box::new(move || {
            let of = planted(at, sound.number, &sound.instrument, Some(at));
            truth("other", &sound.name, &causes()[at].key, of.truth)
        }));
    }
    let largest = (0..causes().len()).filter(|at| has_largest(&causes()[*at]));
    for (at, sound) in largest.flat_map(|at| others.iter().chain([&first]).map(move |sound| (at, sound))) {
        jobs.push(Box::new(move || {
            let case = Chance::new(1000 * u64::from(sound.number) + at as u64).between(3.0, 4.0);
            let ill = with(&sound.instrument, Some(at), case);
            truth("largest", &sound.name, &causes()[at].key, Known::measured(&ill, &mut |_| true).unwrap())
        }));
    }
    let bases = [&others[0], &others[1], &spoiled, &first];
    for (at, base) in bases.into_iter().enumerate() {
        for curve in 0..CURVES {
            let ratio = RATIOS[(curve + at) % RATIOS.len()];
            let strike_g = CURVE_1_G + CURVE_STEP_G * curve as f64;
            jobs.push(Box::new(move || {
                let planted = format!("ratio {ratio} strike weight {strike_g}");
                match kind(&base.instrument, (ratio, strike_g)) {
                    Some((_, known)) => truth("kind", &base.name, &planted, known),
                    None => truth("refused", &base.name, &planted, Known::default()),
                }
            }));
        }
    }
    let (next, found) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    on_all_cores(|| {
        while let Some((at, job)) = Some(next.fetch_add(1, Ordering::SeqCst)).and_then(|at| Some((at, jobs.get(at)?))) {
            let truth = job();
            println!("{}", truth.row());
            found.lock().unwrap().insert(at, truth.row());
        }
    });
    let rows: Vec<String> = std::iter::once(header()).chain(found.into_inner().unwrap().into_values()).collect();
    rows.join("\n") + "\n"
}

fn truth(set: &str, grand: &str, planted: &str, known: Known) -> Truth {
    let [set, grand, planted] = [set, grand, planted].map(str::to_owned);
    Truth { set, grand, planted, known }
}

/// Whether a cause has a case beyond the heavy one.
fn has_largest(cause: &Cause) -> bool {
    injected_amount(cause, 4.0) != injected_amount(cause, 3.0)
}

/// An instrument with a ratio by the equation of balance and a strike weight, regulated, and leaded to a balance weight
/// as far as its key bears, with its readings; `None` if it cannot be regulated.
fn kind(grand: &Instrument, (ratio, strike_g): (f64, f64)) -> Option<(Instrument, Known)> {
    let go_on = &mut |_: f64| true;
    let own = diagnose(&Known::measured(grand, go_on).unwrap(), KEY).geometry.ratio?;
    let factor = ratio / (0.5 * (own.low + own.high));
    let model = KeyModel::of(grand).unwrap();
    let (c, h) = (model.capstan_mm, model.heel_mm);
    let mut made = grand.clone();
    Work::Capstan { by_mm: c * h * (1.0 - factor) / (h + factor * c) }.carry_out(&mut made, go_on).unwrap();
    Work::Hammer { by_g: strike_g - model.strike_weight_g }.carry_out(&mut made, go_on).unwrap();
    let regulated = regulate(&made, &Goal::norms(), &Protocol::default(), &mut |_| true).ok()?;
    if !regulated.all_met() {
        return None;
    }
    let mut leaded = regulated.instrument;
    let known = Known::measured(&leaded, go_on).ok()?;
    let (balance_g, front_g) = (known.balance_g()?, known.get("front_weight_g")?);
    let by_g = (front_g + balance_g - LEADED_TO_G).clamp(FRONTS_G[0], FRONTS_G[1]) - front_g;
    Work::FrontWeight { by_g }.carry_out(&mut leaded, go_on).unwrap();
    let known = Known::measured(&leaded, go_on).ok()?;
    Some((leaded, known))
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
    /// Probabilities of the planted causes.
    pub planted: Vec<(&'static str, f64)>,
    /// The likeliest cause and its probability.
    pub first: (&'static str, f64),
}

impl Told {
    /// Whether the likeliest cause was planted.
    pub fn is_first(&self) -> bool {
        self.planted.iter().any(|(cause, _)| *cause == self.first.0)
    }

    /// Every cause with its probability, and whether it was planted. Leads follow from a planted ratio and hammer, and
    /// are left out there.
    pub fn all(&self) -> impl Iterator<Item = (f64, bool)> {
        let is_kind = self.truth.set == "kind";
        let told = causes().iter().zip(&self.found.probabilities);
        told.filter(move |(cause, _)| !(is_kind && cause.key.starts_with("leads_")))
            .map(|(cause, p)| (*p, self.planted.iter().any(|(own, _)| *own == cause.key)))
    }
}

/// How the truths are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// To a sheet's precision.
    Sheet,
    /// With a bench's errors.
    Bench,
}

/// Truths of a set as they are read, each off by up to an error and without the tests that are taken on request,
/// diagnosed. Tests of one process share the answers.
pub fn told(set: &'static str, reading: Reading) -> &'static [Told] {
    type Answers = OnceLock<Vec<Told>>;
    static KNOWN: Mutex<Vec<(&str, Reading, &Answers)>> = Mutex::new(Vec::new());
    let answers = {
        let mut known = KNOWN.lock().unwrap();
        match known.iter().find(|(own, by, _)| (*own, *by) == (set, reading)) {
            Some((.., answers)) => *answers,
            None => {
                let answers: &Answers = Box::leak(Box::default());
                known.push((set, reading, answers));
                answers
            }
        }
    };
    answers.get_or_init(|| {
        let truths: Vec<Truth> = truths().into_iter().filter(|truth| truth.set == set).collect();
        let (place, told) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        on_all_cores(|| {
            loop {
                let at = place.fetch_add(1, Ordering::SeqCst);
                if at >= truths.len() {
                    break;
                }
                let one = diagnosed(at, truths[at].clone(), reading);
                told.lock().unwrap().push((at, one));
            }
        });
        let mut told = told.into_inner().unwrap();
        told.sort_by_key(|(at, _)| *at);
        told.into_iter().map(|(_, one)| one).collect()
    })
}

fn diagnosed(at: usize, truth: Truth, reading: Reading) -> Told {
    let error = match reading {
        Reading::Sheet => |_: &str, precision: f64| precision,
        Reading::Bench => bench_error,
    };
    let mut known = read_within(&truth.known, error, &mut Chance::new(7000 + at as u64));
    ASKED.iter().for_each(|name| known.set(name, None));
    let found = diagnose(&known, KEY);
    let of = |at: usize| found.probabilities.get(at).copied().unwrap_or(0.0);
    let own = truth.causes();
    let all = causes().iter().enumerate();
    let planted = all.filter(|(_, cause)| own.contains(&&*cause.key)).map(|(at, cause)| (&*cause.key, of(at)));
    let planted = planted.collect();
    let first = (0..causes().len()).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap();
    let first = (&*causes()[first].key, of(first));
    Told { truth, found, planted, first }
}

/// Mean logarithm of the probability of what was planted.
pub fn log_score(told: &[Told]) -> f64 {
    let all: Vec<f64> = told.iter().flat_map(|one| &one.planted).map(|(_, p)| p.clamp(LEAST, 1.0).ln()).collect();
    all.iter().sum::<f64>() / all.len() as f64
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
        let planted: Vec<String> = one.planted.iter().map(|(cause, p)| format!("{cause} {p:.3}")).collect();
        let (grand, of) = (&one.truth.grand, &one.truth.planted);
        let (planted, named) = (planted.join(" "), named.join(" "));
        let _ = writeln!(text, "  {grand:22} {of:34} {planted:24} first {first} {p:.2}  named {named}");
        text
    })
}
