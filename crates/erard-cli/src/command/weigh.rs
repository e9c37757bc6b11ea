//! `erard keyboard --weigh`: from a table of weights to a work list.

use std::path::Path;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument::utf8;
use erard::keyboard::{KEYS, Keyboard};
use erard_workshop::balance::{BalancedKey, KeyModel, LEADS_G, Target, check, plan, read};
use erard_workshop::cores;
use erard_workshop::measure::MeasureError;

use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs;
use crate::paper::Headed;
use crate::progress::Progress;
use crate::say;
use crate::units::Lengths;
use crate::weigh::{Work, html, report, table, text, weighed_svg};

/// What is asked of weighed keys.
#[derive(Debug, Args)]
pub(crate) struct WeighOptions {
    /// Weights measured on a piano, a CSV with key (or note), strike weight, front weight, down-weight and up-weight;
    /// keys and cells may be missing. Writes a work list of leads, hammers and capstans. Lengths and unmeasured values
    /// come from KEYBOARD
    #[arg(long, value_name = "MEASURED.csv", conflicts_with_all = ["every", "key"])]
    weigh: Option<std::path::PathBuf>,
    /// Target for every key: balance=38g, or inertia=0.25kg, or both [default: the median balance weight]
    #[arg(long = "target", value_name = "WHAT=VALUE", requires = "weigh")]
    targets: Vec<String>,
    /// First bring the strike weights to their smooth curve (or to the target inertia), then add leads
    #[arg(long, requires = "weigh")]
    hammers: bool,
    /// Masses of the available leads, g [default: 14,10,7,4]
    #[arg(long, value_name = "G,G,..", value_delimiter = ',', requires = "weigh")]
    leads: Vec<f64>,
    /// Number of keys to check in the dynamic model, from bass to treble
    #[arg(long, value_name = "KEYS", default_value_t = 3, requires = "weigh")]
    sample: usize,
    #[command(flatten)]
    lengths: Lengths,
    #[command(flatten)]
    headed: Headed,
}

/// Most kinds of leads: every combination of up to three is tried.
const MOST_LEADS: usize = 12;

impl WeighOptions {
    /// Whether a table is to be worked on.
    pub(crate) fn asked(&self) -> Option<&Path> {
        self.weigh.as_deref()
    }

    /// Runs the work.
    pub(crate) fn run(&self, path: &Path, keyboard: &Keyboard, out: &OutOptions) -> Result<(), Failure> {
        let target = self.target()?;
        let leads_g = self.leads_g()?;
        let (file, bytes) = inputs::bytes(path)?;
        let measured = read(utf8(&bytes, &file)?, &file).map_err(|error| Failure::Usage(error.to_string()))?;
        let instruments = keyboard.instruments()?;
        let mut output =
            out.prepare("keyboard", &["weigh.csv", "weigh.json", "weigh.html", "weigh.svg", "weigh.png"])?;
        let failed = |error: MeasureError| Failure::Measure { label: keyboard.name.clone(), error };

        let mut progress = Progress::new("weighing");
        let model = |one: &Instrument, _: &mut erard::Progress<'_>| KeyModel::of(one);
        let models = cores::map(&instruments, cores::count(), &mut |share| progress.tell(0.3 * share), model);
        let models = models.map_err(failed)?.into_boxed_slice();
        let models: Box<[KeyModel; KEYS]> = models.try_into().map_err(|_| failed(MeasureError::Lost))?;
        let Some(plan) = plan(&measured, &models, target, &leads_g) else {
            let why = "no key has both a down-weight and an up-weight; expected --target balance=38g";
            return Err(Failure::Usage(format!("{file}: {why}")));
        };
        let sample: Vec<(&BalancedKey, _)> = spread(&plan.keys, self.sample)
            .into_iter()
            .map(|key| (key, instruments[key.measured.key - 1].clone()))
            .collect();
        progress.say("checking");
        let checked = check(&sample, &mut |share| progress.tell(0.3 + 0.7 * share)).map_err(failed)?;
        drop(progress);

        let work = Work {
            name: &keyboard.name,
            file: &file,
            plan: &plan,
            checked: &checked,
            headed: &self.headed,
            lengths: self.lengths,
        };
        let svg = weighed_svg(&work);
        let page = html(&work, &svg);
        output.table("weigh.csv", &table(&work))?;
        output.json("weigh.json", &report(&work))?;
        output.text("weigh.html", &page)?;
        output.figure("weigh", &svg)?;
        let written = output.commit()?;
        say!("{} - {} keys weighed in {file}", keyboard.name, plan.keys.len());
        say!();
        say!("{}", text(&work).trim_end_matches('\n'));
        say!();
        say!("{written}");
        Ok(())
    }

    fn target(&self) -> Result<Target, Failure> {
        let mut target = Target { balance_weight_g: None, inertia_kg: None, hammers: self.hammers };
        for text in &self.targets {
            let wrong = |expected: &str| Failure::Usage(format!("--target {text}: expected {expected}"));
            let (what, value) = text.split_once('=').ok_or_else(|| wrong("balance=38g or inertia=0.25kg"))?;
            let within = |unit: &str, [least, most]: [f64; 2]| {
                let bare = value.trim().trim_end_matches(unit).trim();
                let number = bare.parse::<f64>().ok().filter(|x| (least..=most).contains(x));
                number.ok_or_else(|| wrong(&format!("{what}= and a number from {least} to {most} {unit}")))
            };
            let place = match what.trim() {
                "balance" => (&mut target.balance_weight_g, within("g", [10.0, 90.0])?),
                "inertia" => (&mut target.inertia_kg, within("kg", [0.05, 1.0])?),
                _ => return Err(wrong("balance=38g or inertia=0.25kg")),
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
        let leads: Vec<f64> = if self.leads.is_empty() { LEADS_G.to_vec() } else { self.leads.clone() };
        match leads.iter().find(|mass| !(1.0..=50.0).contains(*mass)) {
            Some(mass) => Err(Failure::Usage(format!("--leads: {mass} g; expected masses from 1 to 50 g"))),
            None if leads.len() > MOST_LEADS => {
                Err(Failure::Usage(format!("--leads: {} masses; expected {MOST_LEADS} at most", leads.len())))
            }
            None => Ok(leads),
        }
    }
}

/// So many keys that something can be done to, spread over those that were weighed.
fn spread(keys: &[BalancedKey], count: usize) -> Vec<&BalancedKey> {
    let able = |key: &&BalancedKey| {
        let is_off = key.leads.as_ref().is_none_or(|leads| leads.front_weight_g != 0.0);
        is_off && key.balance_weight_g.is_some() && key.measured.front_weight_g.is_some()
    };
    let able: Vec<&BalancedKey> = keys.iter().filter(able).collect();
    let count = count.min(able.len());
    (0..count)
        .filter_map(|k| able.get(if count > 1 { k * (able.len() - 1) / (count - 1) } else { able.len() / 2 }))
        .copied()
        .collect()
}
