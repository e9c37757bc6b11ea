//! The work list as text, CSV and JSON.

use std::fmt::Write as _;
use std::io::Write;

use erard::keyboard::{KEYS, note_name};
use erard_workshop::balance::{BalancedKey, Checked, Lead, Remedy};
use serde::Serialize;

use super::{HAMMER_OFF_G, Work, capstan_text, leads_text};
use crate::table::shortest;

/// The list for people: every key that was weighed, and what was checked.
pub(crate) fn text(work: &Work<'_>) -> String {
    let plan = work.plan;
    let mut out = String::new();
    let number =
        |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |x| format!("{:.decimals$}", x + 0.0));
    let _ = writeln!(
        out,
        "  {:>3} {:<4}{:>6}{:>6}{:>6}{:>8}{:>7}{:>7}{:>7}{:>7}  {:<34}{:>8}  capstan",
        "key", "note", "ratio", "F g", "BW g", "inertia", "SW g", "aim", "FW g", "aim", "leads", "or SW"
    );
    for key in &plan.keys {
        let leads = key.leads.as_ref().map_or("not by leads".to_owned(), |leads| leads_text(leads, work.lengths));
        let strike = key.strike_change_g.map_or("-".to_owned(), |by| format!("{by:+.1} g"));
        let capstan = key.capstan_move_mm.map_or("-".to_owned(), |by| capstan_text(by, work.lengths));
        let line = format!(
            "  {:>3} {:<4}{:>6}{:>6}{:>6}{:>8}{:>7}{:>7}{:>7}{:>7}  {leads:<34}{strike:>8}  {capstan}{}",
            key.measured.key,
            key.note,
            number(key.ratio, 2),
            number(key.friction_weight_g, 1),
            number(key.balance_weight_g, 1),
            number(key.inertia_kg, 3),
            number(key.strike_weight_g, 1),
            number(key.target_strike_weight_g, 1),
            number(key.measured.front_weight_g, 1),
            number(key.target_front_weight_g, 1),
            if key.from_curves { "  ~" } else { "" },
        );
        let _ = writeln!(out, "{}", line.trim_end());
    }
    let _ = writeln!(out);
    for line in remarks(work) {
        let _ = writeln!(out, "  {line}");
    }
    out
}

/// What is worth saying below the list.
pub(crate) fn remarks(work: &Work<'_>) -> Vec<String> {
    let plan = work.plan;
    let mut lines = vec![format!(
        "Aim: a balance weight of {:.1} g{}. Each of leads, strike weight and capstan (forward: to the player) would do it alone{}.",
        plan.target_balance_weight_g,
        plan.target.inertia_kg.map_or(String::new(), |kg| format!(" and an inertia of {kg} kg")),
        if plan.target.hammers { "; the leads, after the hammers have come to their aim" } else { "" }
    )];
    if plan.keys.iter().any(|key| key.from_curves) {
        lines.push("~ something was not weighed: the smooth curve stands in for it.".to_owned());
    }
    let off = |key: &&BalancedKey| {
        let both = key.measured.strike_weight_g.zip(key.target_strike_weight_g);
        both.is_some_and(|(now, aim)| (now - aim).abs() > HAMMER_OFF_G)
    };
    let off: Vec<&str> = plan.keys.iter().filter(off).map(|key| key.note.as_str()).collect();
    if !off.is_empty() {
        let rest = if plan.target.hammers { "they come first" } else { "--hammers brings them there first" };
        lines.push(format!("Hammers more than {HAMMER_OFF_G} g off their curve ({rest}): {}.", off.join(", ")));
    }
    let missing = KEYS - plan.keys.len();
    if missing > 0 {
        lines.push(format!("{missing} keys were not weighed; their aims stand in weigh.json (curves)."));
    }
    for one in work.checked {
        lines.push(checked_text(one, work));
    }
    if let Some(worst) = worst(work.checked) {
        lines.push(format!(
            "The dynamic model and the equation of balance differ by {worst:.2} g at most in that sample."
        ));
    }
    lines
}

/// The largest difference of model and equation, g.
fn worst(checked: &[Checked]) -> Option<f64> {
    checked.iter().filter_map(|one| Some((one.in_model_g? - one.by_equation_g).abs())).reduce(f64::max)
}

fn checked_text(one: &Checked, work: &Work<'_>) -> String {
    let what = match &one.remedy {
        Remedy::Leads(leads) => format!("leads {}", leads_text(leads, work.lengths)),
        Remedy::Strike(by_g) => format!("strike weight {by_g:+.1} g"),
        Remedy::Capstan(by_mm) => format!("capstan {}", capstan_text(*by_mm, work.lengths)),
    };
    let model = one.in_model_g.map_or("no weight moves the key".to_owned(), |g| format!("{g:+.1} g"));
    format!(
        "Checked, {}: {what}: balance weight {:+.1} g by the equation, {model} in the model.",
        note_name(one.key),
        one.by_equation_g
    )
}

/// Writes one row per key.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_csv(work: &Work<'_>, writer: &mut dyn Write) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record([
        "key",
        "note",
        "strike_weight_g",
        "front_weight_g",
        "down_weight_g",
        "up_weight_g",
        "balance_weight_g",
        "friction_weight_g",
        "ratio",
        "inertia_kg",
        "from_curves",
        "target_strike_weight_g",
        "target_front_weight_g",
        "leads_out",
        "leads_in",
        "strike_weight_change_g",
        "capstan_to_the_player_mm",
        "balance_weight_after_leads_g",
        "inertia_after_leads_kg",
    ])?;
    for key in &work.plan.keys {
        let mut cells = vec![key.measured.key.to_string(), key.note.clone()];
        let number = |value: Option<f64>| {
            let mut text = String::new();
            if let Some(x) = value.filter(|x| x.is_finite()) {
                // A thousandth of a gram: what lies beyond is rounding.
                shortest((x * 1e4).round() / 1e4, &mut text);
            }
            text
        };
        let m = &key.measured;
        let weights = [
            m.strike_weight_g,
            m.front_weight_g,
            m.down_weight_g,
            m.up_weight_g,
            key.balance_weight_g,
            key.friction_weight_g,
            key.ratio,
            key.inertia_kg,
        ];
        cells.extend(weights.map(number));
        cells.push(u8::from(key.from_curves).to_string());
        cells.extend([key.target_strike_weight_g, key.target_front_weight_g].map(number));
        let list = |of: fn(&erard_workshop::balance::LeadWork) -> &Vec<Lead>| {
            let each = key.leads.iter().flat_map(of).map(|lead| format!("{}@{}", lead.mass_g, lead.at_mm));
            each.collect::<Vec<_>>().join(" ")
        };
        cells.extend([list(|work| &work.out), list(|work| &work.put)]);
        let rest = [key.strike_change_g, key.capstan_move_mm, key.after_balance_weight_g, key.after_inertia_kg];
        cells.extend(rest.map(number));
        csv.write_record(cells)?;
    }
    csv.flush()
}

/// The plan for programs.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    keyboard: String,
    measured: String,
    target_balance_weight_g: f64,
    target_inertia_kg: Option<f64>,
    hammers_first: bool,
    keys: Vec<KeyReport>,
    curves: Vec<CurveReport>,
    checked: Vec<CheckReport>,
    largest_difference_g: Option<f64>,
}

#[derive(Debug, Serialize)]
struct KeyReport {
    key: usize,
    note: String,
    balance_weight_g: Option<f64>,
    friction_weight_g: Option<f64>,
    ratio: Option<f64>,
    inertia_kg: Option<f64>,
    from_curves: bool,
    key_ratio: f64,
    whippen_weight_g: f64,
    target_strike_weight_g: Option<f64>,
    target_front_weight_g: Option<f64>,
    leads: Option<LeadReport>,
    strike_weight_change_g: Option<f64>,
    capstan_to_the_player_mm: Option<f64>,
    balance_weight_after_leads_g: Option<f64>,
    inertia_after_leads_kg: Option<f64>,
}

/// Grams and millimetres in front of the balance pin.
#[derive(Debug, Serialize)]
struct LeadReport {
    out: Vec<[f64; 2]>,
    put: Vec<[f64; 2]>,
    front_weight_g: f64,
}

#[derive(Debug, Serialize)]
struct CurveReport {
    key: usize,
    strike_weight_g: Option<f64>,
    ratio: Option<f64>,
    target_strike_weight_g: Option<f64>,
    target_front_weight_g: Option<f64>,
}

#[derive(Debug, Serialize)]
struct CheckReport {
    key: usize,
    remedy: &'static str,
    balance_weight_by_equation_g: f64,
    balance_weight_in_model_g: Option<f64>,
}

impl Report {
    /// Of a plan.
    pub(crate) fn new(work: &Work<'_>) -> Self {
        let plan = work.plan;
        let leads = |key: &BalancedKey| {
            let pairs = |leads: &[Lead]| leads.iter().map(|lead| [lead.mass_g, lead.at_mm]).collect();
            key.leads.as_ref().map(|work| LeadReport {
                out: pairs(&work.out),
                put: pairs(&work.put),
                front_weight_g: work.front_weight_g,
            })
        };
        let keys = plan.keys.iter().map(|key| KeyReport {
            key: key.measured.key,
            note: key.note.clone(),
            balance_weight_g: key.balance_weight_g,
            friction_weight_g: key.friction_weight_g,
            ratio: key.ratio,
            inertia_kg: key.inertia_kg,
            from_curves: key.from_curves,
            key_ratio: key.key_ratio,
            whippen_weight_g: key.whippen_weight_g,
            target_strike_weight_g: key.target_strike_weight_g,
            target_front_weight_g: key.target_front_weight_g,
            leads: leads(key),
            strike_weight_change_g: key.strike_change_g,
            capstan_to_the_player_mm: key.capstan_move_mm,
            balance_weight_after_leads_g: key.after_balance_weight_g,
            inertia_after_leads_kg: key.after_inertia_kg,
        });
        let curves = &plan.curves;
        let of = |curve: &Option<[f64; KEYS]>, at: usize| curve.map(|curve| curve[at]);
        let curves = (0..KEYS).map(|at| CurveReport {
            key: at + 1,
            strike_weight_g: of(&curves.strike_weight_g, at),
            ratio: of(&curves.ratio, at),
            target_strike_weight_g: of(&curves.target_strike_weight_g, at),
            target_front_weight_g: of(&curves.target_front_weight_g, at),
        });
        let checked = work.checked.iter().map(|one| CheckReport {
            key: one.key,
            remedy: match one.remedy {
                Remedy::Leads(_) => "leads",
                Remedy::Strike(_) => "strike_weight",
                Remedy::Capstan(_) => "capstan",
            },
            balance_weight_by_equation_g: one.by_equation_g,
            balance_weight_in_model_g: one.in_model_g,
        });
        Report {
            keyboard: work.name.to_owned(),
            measured: work.file.to_owned(),
            target_balance_weight_g: plan.target_balance_weight_g,
            target_inertia_kg: plan.target.inertia_kg,
            hammers_first: plan.target.hammers,
            keys: keys.collect(),
            curves: curves.collect(),
            checked: checked.collect(),
            largest_difference_g: worst(work.checked),
        }
    }
}
