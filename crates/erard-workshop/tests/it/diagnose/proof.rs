//! Pianos unknown to the program, with one fault each.
//!
//! A sound grand of the ensemble gets one cause of the table, with a random amount between its light and its heavy
//! case. The program gets readings only, each off by up to its precision. A requested measurement is taken, too, at
//! most twice. The cause named first is undone on the piano, and all is measured again.

use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};

use erard::instrument::{Instrument, InstrumentFile};
use erard_workshop::diagnose::{Diagnosis, Known, Ranked, Standing, causes, diagnose, entries, inject_case};
use erard_workshop::sample::Sampled;
use erard_workshop::worklist::{ReadingQuantity, Readings};

use crate::worklist::hand::Chance;

pub const GRAND: &str = "concert-grand";
/// Key whose usual ranges hold.
pub const KEY: usize = 40;
/// Bench tests, taken on request only.
const ASKED: [&str; 3] = ["key_alone_friction_g", "hammer_flange_g", "whippen_flange_g"];
/// Most requested measurements that are taken.
const TIMES: usize = 2;

/// Returns a sample if it is sound.
pub fn sound_sample(sampled: &Sampled, number: u32) -> Option<Instrument> {
    let go_on = &mut |_: f64| true;
    let text = sampled.text(number, go_on).unwrap();
    let grand = InstrumentFile::parse(&text, GRAND).unwrap().instrument;
    let readings = Readings::of(&grand, go_on).unwrap();
    ReadingQuantity::ALL.into_iter().all(|quantity| !readings.is_out(quantity, KEY)).then_some(grand)
}

/// Returns the readings of the truth: each off by up to its precision.
fn read(truth: &Known, chance: &mut Chance) -> Known {
    read_within(truth, |_, precision| precision, chance)
}

/// Returns the readings of the truth, each off by up to an error that its name and precision give.
pub fn read_within(truth: &Known, error: impl Fn(&str, f64) -> f64, chance: &mut Chance) -> Known {
    let mut read = truth.clone();
    for entry in entries() {
        let off = error(entry.name, entry.precision) * chance.either_way();
        read.set(entry.name, truth.get(entry.name).map(|value| value + off));
    }
    read
}

/// All causes of an answer, named, withheld and left open, the likeliest first.
pub fn ranked(found: &Diagnosis) -> Vec<&Ranked> {
    let mut all: Vec<&Ranked> = found.causes.iter().chain(&found.withheld).chain(&found.undecided).collect::<Vec<_>>();
    all.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    all
}

/// Prints a truth in one line, so that it can be diagnosed again without its simulation.
pub fn print_truth(name: &str, case: f64, truth: &Known) {
    let of = |entry: &erard_workshop::diagnose::Entry| Some(format!("{}={:.4}", entry.name, truth.get(entry.name)?));
    let readings: Vec<String> = entries().iter().filter_map(of).collect();
    let check = if truth.is_not_caught { " check_mm=none" } else { "" };
    println!("truth {name} {case:.3} {}{check}", readings.join(" "));
}

/// The outcome for one piano.
#[derive(Debug)]
pub struct Course {
    at: usize,
    number: u32,
    /// Planted cause; `None` for a sound piano.
    cause: Option<usize>,
    case: f64,
    /// Rank of the planted cause, from 1, before a requested measurement, after one, after two; 0 if it was not named.
    ranks: [usize; TIMES + 1],
    is_work: bool,
    asked: Vec<&'static str>,
    /// Lines out of range by more than their reading's error, before and after the first cause was undone.
    out: [usize; 2],
    named: String,
}

fn out(known: &Known) -> usize {
    diagnose(known, KEY).lines.iter().filter(|line| line.standing == Standing::Out).count()
}

/// A piano with its fault, and its true readings.
pub struct Planted {
    pub at: usize,
    pub number: u32,
    pub cause: Option<usize>,
    pub case: f64,
    pub ill: Instrument,
    pub truth: Known,
}

/// Plants a cause, large enough to bring a line out of range.
pub fn planted(at: usize, number: u32, sound: &Instrument, cause: Option<usize>) -> Planted {
    let go_on = &mut |_: f64| true;
    let mut case = chance_of(at, number).between(1.0, 3.0);
    let mut ill = with(sound, cause, case);
    let mut truth = Known::measured(&ill, go_on).unwrap();
    // A fault must show in the readings: otherwise it is increased.
    while cause.is_some() && out(&truth) == 0 && case < 3.0 {
        case = (case + 0.5).min(3.0);
        ill = with(sound, cause, case);
        truth = Known::measured(&ill, go_on).unwrap();
    }
    Planted { at, number, cause, case, ill, truth }
}

fn chance_of(at: usize, number: u32) -> Chance {
    Chance::new(1000 * u64::from(number) + at as u64)
}

/// Puts a case of a cause into a sound piano.
pub fn with(sound: &Instrument, cause: Option<usize>, case: f64) -> Instrument {
    match cause.map(|at| &causes()[at]) {
        Some(cause) => inject_case(sound, cause, case, false, &mut |_| true).unwrap(),
        None => sound.clone(),
    }
}

/// Reads a piano, diagnoses it, takes requested measurements, and acts on the answer.
pub fn course(planted: &Planted) -> Course {
    let go_on = &mut |_: f64| true;
    let Planted { at, number, cause, case, ill, truth } = planted;
    let (at, number, cause, case) = (*at, *number, *cause, *case);
    print_truth(cause.map_or("sound", |at| &causes()[at].key), case, truth);
    // Random numbers independent of the case's.
    let mut chance = chance_of(at + 500, number);
    let seen = read(truth, &mut chance);
    let mut known = seen.clone();
    ASKED.iter().for_each(|name| known.set(name, None));
    let mut found = diagnose(&known, KEY);
    let is_work = found.is_work();
    let rank = |found: &Diagnosis| {
        let place = ranked(found)
            .iter()
            .position(|ranked| Some(ranked.cause.key.as_str()) == cause.map(|at| causes()[at].key.as_str()));
        place.map_or(0, |place| place + 1)
    };
    let mut ranks = [rank(&found); TIMES + 1];
    let mut asked = Vec::new();
    for time in 1..=TIMES {
        let Some(next) = found.next.as_ref().map(|next| next.name) else { break };
        asked.push(next);
        known.set(next, seen.get(next));
        found = diagnose(&known, KEY);
        ranks[time..].fill(rank(&found));
    }
    let mut out_of = [out(truth); 2];
    if let Some(first) = ranked(&found).first() {
        let undone = inject_case(ill, first.cause, first.case, true, go_on).unwrap();
        out_of[1] = out(&Known::measured(&undone, go_on).unwrap());
    }
    let named = ranked(&found).into_iter().map(|ranked| format!("{} {:.2}", ranked.cause.key, ranked.probability));
    Course { at, number, cause, case, ranks, is_work, asked, out: out_of, named: named.collect::<Vec<_>>().join(", ") }
}

/// The outcome over many pianos.
#[derive(Debug, Default)]
pub struct Tally {
    pub courses: Vec<Course>,
    /// Sound pianos: those without work, and all.
    pub healthy: [usize; 2],
}

impl Tally {
    pub fn of(mut courses: Vec<Course>) -> Self {
        courses.sort_by_key(|course| course.at);
        let sound: Vec<bool> =
            courses.iter().filter(|course| course.cause.is_none()).map(|course| course.is_work).collect();
        let healthy = [sound.iter().filter(|is_work| !**is_work).count(), sound.len()];
        Tally { courses, healthy }
    }

    fn ill(&self) -> impl Iterator<Item = &Course> {
        self.courses.iter().filter(|course| course.cause.is_some())
    }

    pub fn pianos(&self) -> usize {
        self.ill().count()
    }

    /// Number of pianos whose planted cause was named first, after this number of requested measurements.
    pub fn first(&self, time: usize) -> usize {
        self.ill().filter(|course| course.ranks[time] == 1).count()
    }

    /// Table of planted causes and ranks, and the causes not found.
    pub fn report(&self) -> String {
        let sum = |at: usize| -> usize { self.ill().map(|course| course.out[at]).sum() };
        let mut text = format!(
            "{} planted faults: first {} from the sheet, {} after one measurement that was asked for, {} after two; sound {} of {} without \
             work; lines out {} before, {} after the first cause was undone\n",
            self.pianos(),
            self.first(0),
            self.first(1),
            self.first(2),
            self.healthy[0],
            self.healthy[1],
            sum(0),
            sum(1)
        );
        for (at, cause) in causes().iter().enumerate() {
            let of: Vec<&Course> = self.ill().filter(|course| course.cause == Some(at)).collect();
            let ranks: Vec<String> = of.iter().map(|course| format!("{:?}", course.ranks)).collect();
            if !of.is_empty() {
                let _ = writeln!(text, "  {:18} {}", cause.key, ranks.join(" "));
            }
        }
        for course in self.courses.iter().filter(|course| course.cause.is_some() && course.ranks[TIMES] != 1) {
            let planted = course.cause.map_or("", |at| causes()[at].key.as_str());
            let _ = writeln!(
                text,
                "  sample {}: {planted} (case {:.2}), work {}, asked {:?}, named {}",
                course.number, course.case, course.is_work, course.asked, course.named
            );
        }
        text
    }
}

/// Returns the first sound samples of a built-in instrument from a number on. All cores draw; the result does not
/// depend on their number.
pub fn sound_samples(name: &str, grands: usize, from: u32) -> Vec<(u32, Instrument)> {
    let go_on = &mut |_: f64| true;
    let sampled = Sampled::of_file(Instrument::builtin_text(name).unwrap(), name, go_on).unwrap();
    let (next, sound) = (AtomicU32::new(from), Mutex::new(Vec::<(u32, Instrument)>::new()));
    let draw = || {
        while sound.lock().unwrap().len() < grands {
            let number = next.fetch_add(1, Ordering::SeqCst);
            if let Some(grand) = sound_sample(&sampled, number) {
                sound.lock().unwrap().push((number, grand));
            }
        }
    };
    on_all_cores(draw);
    let mut sound = sound.into_inner().unwrap();
    sound.sort_by_key(|(number, _)| *number);
    sound.truncate(grands);
    sound
}

pub fn on_all_cores(work: impl Fn() + Sync) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..cores).for_each(|_| drop(scope.spawn(&work))));
}

/// Tests faults, each on a copy of one of the grands, kinds in turn from `first_cause` on, and readings of sound
/// grands.
pub fn tally(sound: &[(u32, Instrument)], faults: usize, healthy: usize, first_cause: usize) -> Tally {
    let (place, courses) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    on_all_cores(|| {
        loop {
            let at = place.fetch_add(1, Ordering::SeqCst);
            if at >= faults + healthy {
                break;
            }
            let (number, grand, cause) = dealt(sound, faults, first_cause, at);
            let course = course(&planted(at, number, grand, cause));
            courses.lock().unwrap().push(course);
        }
    });
    Tally::of(courses.into_inner().unwrap())
}

/// Grand and cause of piano number `at`.
pub fn dealt(
    sound: &[(u32, Instrument)],
    faults: usize,
    first_cause: usize,
    at: usize,
) -> (u32, &Instrument, Option<usize>) {
    let cause = (at < faults).then_some((first_cause + at) % causes().len());
    let of = if at < faults { at } else { at - faults };
    let (number, grand) = &sound[of % sound.len()];
    (*number, grand, cause)
}
