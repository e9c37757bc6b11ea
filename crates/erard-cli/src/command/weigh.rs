//! `erard keyboard --measured`: from a table of weights to a work list.

use erard::parameter::{NumberError, Quantity};
use std::path::Path;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument::utf8;
use erard::key::note_name;
use erard::keyboard::{KEYS, Keyboard};
use erard_workshop::balance::{BalancedKey, KeyModel, LEADS_G, check, read, unused_columns};
use erard_workshop::cores;
use erard_workshop::measure::MeasureError;
use erard_workshop::worklist::{KeyboardGoal, KeyboardList, SECTION_ENDS, carry_out, keyboard_list};
use serde_json::Value;

use super::options::key;
use super::out::OutOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::number::{Values, list, number, whole};
use crate::paper::PageHeader;
use crate::print_line;
use crate::session::Session;
use crate::units::Lengths;
use crate::weigh::{Work, again, again_text, html, report, table, text, weighed_picture};

/// What is asked of weighed keys.
#[derive(Debug, Args)]
pub(crate) struct WeighOptions {
    /// Weights measured on a piano, a CSV with key (or note), strike weight, front weight, down-weight and up-weight
    /// (or balance weight and friction weight); keys and cells may be missing. Writes a work list by operation:
    /// friction, hammers, leads. Lengths and unmeasured values come from KEYBOARD
    #[arg(long, value_name = "MEASURED.csv", conflicts_with_all = ["every", "key"])]
    measured: Option<std::path::PathBuf>,
    /// Target for every key: balance=38g, ratio=5.8 (of the naturals), inertia=0.25kg, or several; without a unit g and
    /// kg [default: the usual balance weight nearest to the median, 38 g if few keys were weighed]
    #[arg(long = "target", value_name = "WHAT=VALUE", requires = "measured")]
    targets: Vec<String>,
    /// First bring all strike weights to their smooth curve (or to the target inertia), then add leads. Without it,
    /// only hammers that differ from their neighbours
    #[arg(long, requires = "measured")]
    hammers: bool,
    /// Masses of the available leads, g [default: 14,10,7,4]
    #[arg(long, value_name = "G,G,..", value_parser = list(number(Quantity::Mass, "g")), allow_hyphen_values = true, requires = "measured")]
    lead_masses: Vec<Values>,
    /// Last key of each section of strings but the highest, by number or note: samples of an operation are at the ends
    /// of sections [default: 20,50,70, an estimate for a concert grand]
    #[arg(long = "sections", value_name = "KEY,KEY,..", value_delimiter = ',', value_parser = key, requires = "measured")]
    section_ends: Vec<usize>,
    /// Carry out the list on simulated copies of the keys and weigh them again: again.csv, a table for --measured
    #[arg(long, requires = "measured")]
    simulate_work: bool,
    /// Number of keys to check in the dynamic model, from bass to treble
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<usize>(0, 88), requires = "measured")]
    checked_keys: usize,
    #[command(flatten)]
    lengths: Lengths,
    #[command(flatten)]
    page_header: PageHeader,
}

/// What can be aimed at.
const TARGETS: &str = "balance=38g, ratio=5.8 or inertia=0.25kg";
/// Most kinds of leads: every combination of up to three is tried.
const MAX_LEADS: usize = 12;

impl WeighOptions {
    /// Whether a table is to be worked on.
    pub(crate) fn asked(&self) -> Option<&Path> {
        self.measured.as_deref()
    }

    /// Runs the work.
    pub(crate) fn run(
        &self,
        session: &mut Session,
        path: &Path,
        keyboard: &Keyboard,
        out: &OutOptions,
    ) -> Result<Answer, Failure> {
        let goal = self.goal()?;
        let (file, bytes) = session.inputs.bytes(path)?;
        let measured = read(utf8(&bytes, &file)?, &file).map_err(|error| Failure::Usage(error.to_string()))?;
        let instruments = keyboard.instruments()?;
        let files = ["weigh.csv", "weigh.json", "weigh.html", "weigh.svg", "weigh.png", "again.csv"];
        let mut output = out.prepare(session, "keyboard", &files[..if self.simulate_work { 6 } else { 5 }])?;
        let failed = |error: MeasureError| Failure::Measure { label: keyboard.name.clone(), error: Box::new(error) };

        let mut progress = session.progress("weighing");
        let model = |one: &Instrument, _: &mut erard::Progress<'_>| KeyModel::of(one);
        let models = cores::map(&instruments, cores::count(), &mut |share| progress.tell(0.3 * share), model);
        let models = models.map_err(failed)?.into_boxed_slice();
        let models: Box<[KeyModel; KEYS]> = models.try_into().map_err(|_| failed(MeasureError::Lost))?;
        let Some(mut list) = keyboard_list(&measured, &models, &goal) else {
            let why = "no key has both a down-weight and an up-weight; expected --target balance=38g";
            return Err(Failure::Usage(format!("{file}: {why}")));
        };
        let sample: Vec<(BalancedKey, Instrument)> = spread(&list, self.checked_keys)
            .into_iter()
            .map(|key| {
                let instrument = instruments[key.measured.key - 1].clone();
                (key, instrument)
            })
            .collect();
        progress.say("checking");
        let rest = if self.simulate_work { 0.2 } else { 0.7 };
        let checked = check(&sample, &mut |share| progress.tell(0.3 + rest * share)).map_err(failed)?;
        list.plan.withhold(&checked);
        let weighed_again = if self.simulate_work {
            progress.say("carrying out");
            let tell = &mut |share: f64| progress.tell(0.5 + 0.5 * share);
            Some(carry_out(&list, &instruments, tell).map_err(failed)?)
        } else {
            None
        };
        drop(progress);

        let unused = unused_columns(utf8(&bytes, &file)?, &file);
        let work = Work {
            name: &keyboard.name,
            file: &file,
            list: &list,
            checked: &checked,
            again: weighed_again.as_deref(),
            page_header: &self.page_header,
            lengths: self.lengths,
        };
        let picture = weighed_picture(&work);
        let page = html(&work, &picture.svg());
        output.table(session, "weigh.csv", &table(&work))?;
        let report = report(&work);
        output.json(session, "weigh.json", &report)?;
        output.text(session, "weigh.html", &page)?;
        output.figure(session, "weigh", &picture)?;
        if let Some(keys) = &weighed_again {
            output.table(session, "again.csv", &again(keys))?;
        }
        let written = output.commit(session)?;
        let keys = if list.plan.keys.len() == 1 { "key" } else { "keys" };
        print_line!(
            session,
            "{file} - {} {keys} weighed; what was not comes from {}",
            list.plan.keys.len(),
            keyboard.name
        );
        if !unused.is_empty() {
            print_line!(session, "  Columns that were not used: {}", unused.join(", "));
        }
        let answer = Answer::of(&report)?;
        let all = text(&work);
        answer.begin(session, headlines, "what was weighed key by key, and the list; weigh.html is the list to print");
        print_line!(session, "{}", all.trim_end_matches('\n'));
        print_line!(session);
        if let Some(keys) = weighed_again.as_ref().filter(|_| !list.lines.is_empty()) {
            print_line!(session, "  The list carried out on copies of these keys, weighed again:");
            print_line!(session);
            print_line!(session, "{}", again_text(&work, keys).trim_end_matches('\n'));
            print_line!(session);
        }
        Ok(answer.end(session, &written))
    }

    fn goal(&self) -> Result<KeyboardGoal, Failure> {
        let mut target = KeyboardGoal {
            balance_weight_g: None,
            ratio: None,
            inertia_kg: None,
            hammers: self.hammers,
            leads_g: self.leads_g()?,
            section_ends: if self.section_ends.is_empty() { SECTION_ENDS.to_vec() } else { self.section_ends.clone() },
        };
        for text in &self.targets {
            let wrong = |expected: &str| Failure::Usage(format!("--target {text}: expected {expected}"));
            let (what, value) = text.split_once('=').ok_or_else(|| wrong(TARGETS))?;
            let within =
                |quantity: Quantity, unit: &'static str, [least, most]: [f64; 2]| match quantity.read_in(value, unit) {
                    Ok(number) if (least..=most).contains(&number) => Ok(number),
                    Ok(_) | Err(NumberError::Text { .. }) => {
                        Err(wrong(format!("{what}= and a number from {least} to {most} {unit}").trim_end()))
                    }
                    Err(error) => Err(Failure::Usage(format!("--target {text}: {error}"))),
                };
            let place = match what.trim() {
                "balance" => (&mut target.balance_weight_g, within(Quantity::Weight, "g", [10.0, 90.0])?),
                "ratio" => (&mut target.ratio, within(Quantity::Number, "", [4.0, 9.0])?),
                "inertia" => (&mut target.inertia_kg, within(Quantity::Mass, "kg", [0.05, 1.0])?),
                _ => return Err(wrong(TARGETS)),
            };
            if place.0.replace(place.1).is_some() {
                return Err(Failure::Usage(format!("--target {what} is given twice")));
            }
        }
        // Leads alone can give a key its balance, but no hammer its weight.
        target.hammers |= target.inertia_kg.is_some();
        Ok(target)
    }

    fn leads_g(&self) -> Result<Vec<f64>, Failure> {
        let given: Vec<f64> = self.lead_masses.iter().flat_map(|list| list.0.iter().copied()).collect();
        let leads = if given.is_empty() { LEADS_G.to_vec() } else { given };
        match leads.iter().find(|mass| !(1.0..=50.0).contains(*mass)) {
            Some(mass) => Err(Failure::Usage(format!("--lead-masses: {mass} g; expected masses from 1 to 50 g"))),
            None if leads.len() > MAX_LEADS => {
                Err(Failure::Usage(format!("--lead-masses: {} masses; expected {MAX_LEADS} at most", leads.len())))
            }
            None => Ok(leads),
        }
    }
}

/// Why keys wait, as the answer has it, and in words.
const WAITS: [(&str, &str); 3] = [
    ("leverage_first", "Wait for the leverage"),
    ("friction_first", "Wait for the friction"),
    ("front_weight_ceiling", "Have no room for more lead"),
];

/// The note of a key in the answer.
fn note(key: &Value) -> Option<String> {
    key.as_u64().and_then(|key| usize::try_from(key).ok()).map(note_name)
}

/// Keys of an operation that are named first.
const NAMED: usize = 8;

/// The first lines: on which keys each operation is due.
fn headlines(answer: &Value) -> Vec<String> {
    let mut operations: Vec<(&str, Vec<String>)> = Vec::new();
    for line in answer["work"].as_array().into_iter().flatten() {
        let operation = line["operation"].as_str().unwrap_or_default();
        let key = note(&line["key"]).unwrap_or_default();
        match operations.iter_mut().find(|(own, _)| *own == operation) {
            Some((_, keys)) if keys.contains(&key) => {}
            Some((_, keys)) => keys.push(key),
            None => operations.push((operation, vec![key])),
        }
    }
    let named = |keys: &[String]| {
        let more = if keys.len() > NAMED { format!(" and {} more", keys.len() - NAMED) } else { String::new() };
        format!("{}{more}", keys.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", "))
    };
    let mut lines = Vec::new();
    let leverage = &answer["leverage"];
    if let (Some(keys), Some(of)) = (leverage["keys"].as_array(), leverage["of"].as_u64()) {
        let out = keys.len();
        lines.push(format!("Leverage first: the ratio of {out} of {of} keys is out on one side, so the cause is one."));
    }
    for (why, told) in WAITS {
        let waits = answer["waits"].as_array().into_iter().flatten().filter(|one| one["why"] == why);
        let keys: Vec<String> = waits.filter_map(|one| note(&one["key"])).collect();
        if !keys.is_empty() {
            lines.push(format!("{told}: {}.", named(&keys)));
        }
    }
    if !operations.is_empty() {
        lines.push("To do, in this order:".to_owned());
        lines.extend(operations.iter().map(|(operation, keys)| format!("  {operation}: {}", named(keys))));
    } else if lines.is_empty() {
        lines.push("To do: nothing.".to_owned());
    }
    lines
}

/// So many keys whose work is checked, spread over those that were weighed: of a key that waits for leverage the
/// common move of the capstan line is, of others what leads, hammer or capstan would do.
fn spread(list: &KeyboardList, count: usize) -> Vec<BalancedKey> {
    let to_check = |key: &BalancedKey| {
        if KeyboardList::is_friction_out(key) || key.balance_weight_g.is_none() || key.measured.front_weight_g.is_none()
        {
            return None;
        }
        match &list.leverage {
            Some(out) if list.waits(key) => Some(BalancedKey {
                leads: None,
                strike_change_g: None,
                capstan_move_mm: Some(out.capstan_move_mm),
                ..key.clone()
            }),
            _ => key.front_change_g.is_some_and(|by_g| by_g != 0.0).then(|| key.clone()),
        }
    };
    let able: Vec<BalancedKey> = list.plan.keys.iter().filter_map(to_check).collect();
    let count = count.min(able.len());
    (0..count)
        .filter_map(|k| able.get(if count > 1 { k * (able.len() - 1) / (count - 1) } else { able.len() / 2 }))
        .cloned()
        .collect()
}
