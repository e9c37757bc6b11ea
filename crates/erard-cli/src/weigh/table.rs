//! The work list as text, CSV and JSON.

use std::fmt::Write as _;

use erard::keyboard::{KEYS, note_name};
use erard_workshop::balance::{BalancedKey, Checked, Lead, LeadWork, Remedy};
use serde_json::{Value, json};

use super::{HAMMER_OFF_G, Work, capstan_text, leads_text};
use crate::table::{Table, decimal};

/// The list for people: every key that was weighed, and what was checked.
pub(crate) fn text(work: &Work<'_>) -> String {
    let heads = [
        "key",
        "note",
        "ratio",
        "F g",
        "BW g",
        "inertia",
        "SW g",
        "aim",
        "FW g",
        "aim",
        "or SW",
        "or capstan",
        "leads",
    ];
    let mut out = Table::of(heads, rows(work)).to_string();
    let _ = writeln!(out);
    for line in remarks(work) {
        let _ = writeln!(out, "  {line}");
    }
    out
}

/// The work, a row for every key: key, note, ratio, friction, balance weight, inertia, strike weight and its aim, front
/// weight and its aim, the strike weight or the move of the capstan that would do instead of leads, the leads.
pub(crate) fn rows(work: &Work<'_>) -> Vec<Vec<String>> {
    let row = |key: &BalancedKey| {
        vec![
            format!("{}{}", key.measured.key, if key.from_curves { " ~" } else { "" }),
            key.note.clone(),
            decimal(key.ratio, 2),
            decimal(key.friction_weight_g, 1),
            decimal(key.balance_weight_g, 1),
            decimal(key.inertia_kg, 3),
            decimal(key.strike_weight_g, 1),
            decimal(key.target_strike_weight_g, 1),
            decimal(key.measured.front_weight_g, 1),
            decimal(key.target_front_weight_g, 1),
            key.strike_change_g.map_or("-".to_owned(), |by| format!("{by:+.1} g")),
            key.capstan_move_mm.map_or("-".to_owned(), |by| capstan_text(by, work.lengths)),
            key.leads.as_ref().map_or("not by leads".to_owned(), |leads| leads_text(leads, work.lengths)),
        ]
    };
    work.plan.keys.iter().map(row).collect()
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

/// weigh.csv: a row for every key that was weighed.
pub(crate) fn table(work: &Work<'_>) -> Table<'static> {
    type Number = (&'static str, fn(&BalancedKey) -> Option<f64>);
    const WEIGHED: [Number; 11] = [
        ("strike_weight_g", |key| key.measured.strike_weight_g),
        ("front_weight_g", |key| key.measured.front_weight_g),
        ("down_weight_g", |key| key.measured.down_weight_g),
        ("up_weight_g", |key| key.measured.up_weight_g),
        ("balance_weight_g", |key| key.balance_weight_g),
        ("friction_weight_g", |key| key.friction_weight_g),
        ("ratio", |key| key.ratio),
        ("inertia_kg", |key| key.inertia_kg),
        ("from_curves", |key| Some(f64::from(u8::from(key.from_curves)))),
        ("target_strike_weight_g", |key| key.target_strike_weight_g),
        ("target_front_weight_g", |key| key.target_front_weight_g),
    ];
    const WORK: [Number; 4] = [
        ("strike_weight_change_g", |key| key.strike_change_g),
        ("capstan_to_the_player_mm", |key| key.capstan_move_mm),
        ("balance_weight_after_leads_g", |key| key.after_balance_weight_g),
        ("inertia_after_leads_kg", |key| key.after_inertia_kg),
    ];
    let keys = &work.plan.keys;
    let numbers = |table: Table<'static>, (name, get): Number| {
        table.optional(name, keys.iter().map(|key| get(key).map(|x| (x * 1e4).round() / 1e4)))
    };
    let leads = |of: fn(&LeadWork) -> &Vec<Lead>| {
        let list = |key: &BalancedKey| {
            let each = key.leads.iter().flat_map(of).map(|lead| format!("{}@{}", lead.mass_g, lead.at_mm));
            each.collect::<Vec<_>>().join(" ")
        };
        keys.iter().map(list).collect::<Vec<_>>()
    };
    let start = Table::default()
        .optional("key", keys.iter().map(|key| Some(key.measured.key as f64)))
        .words("note", keys.iter().map(|key| key.note.clone()));
    let weighed = WEIGHED.into_iter().fold(start, numbers);
    let led = weighed.words("leads_out", leads(|work| &work.out)).words("leads_in", leads(|work| &work.put));
    WORK.into_iter().fold(led, numbers)
}

/// weigh.json.
pub(crate) fn report(work: &Work<'_>) -> Value {
    let (plan, curves) = (work.plan, &work.plan.curves);
    let leads = |work: &LeadWork| {
        let pairs = |leads: &[Lead]| leads.iter().map(|lead| json!([lead.mass_g, lead.at_mm])).collect::<Value>();
        json!({"out": pairs(&work.out), "put": pairs(&work.put), "front_weight_g": work.front_weight_g})
    };
    let key = |key: &BalancedKey| {
        json!({
            "key": key.measured.key,
            "note": key.note,
            "balance_weight_g": key.balance_weight_g,
            "friction_weight_g": key.friction_weight_g,
            "ratio": key.ratio,
            "inertia_kg": key.inertia_kg,
            "from_curves": key.from_curves,
            "key_ratio": key.key_ratio,
            "whippen_weight_g": key.whippen_weight_g,
            "target_strike_weight_g": key.target_strike_weight_g,
            "target_front_weight_g": key.target_front_weight_g,
            "leads": key.leads.as_ref().map(leads),
            "strike_weight_change_g": key.strike_change_g,
            "capstan_to_the_player_mm": key.capstan_move_mm,
            "balance_weight_after_leads_g": key.after_balance_weight_g,
            "inertia_after_leads_kg": key.after_inertia_kg,
        })
    };
    let curve = |at: usize| {
        let of = |curve: &Option<[f64; KEYS]>| curve.map(|curve| curve[at]);
        json!({
            "key": at + 1,
            "strike_weight_g": of(&curves.strike_weight_g),
            "ratio": of(&curves.ratio),
            "target_strike_weight_g": of(&curves.target_strike_weight_g),
            "target_front_weight_g": of(&curves.target_front_weight_g),
        })
    };
    let checked = |one: &Checked| {
        let remedy = match one.remedy {
            Remedy::Leads(_) => "leads",
            Remedy::Strike(_) => "strike_weight",
            Remedy::Capstan(_) => "capstan",
        };
        json!({
            "key": one.key,
            "remedy": remedy,
            "balance_weight_by_equation_g": one.by_equation_g,
            "balance_weight_in_model_g": one.in_model_g,
        })
    };
    json!({
        "keyboard": work.name,
        "measured": work.file,
        "target_balance_weight_g": plan.target_balance_weight_g,
        "target_inertia_kg": plan.target.inertia_kg,
        "hammers_first": plan.target.hammers,
        "keys": plan.keys.iter().map(key).collect::<Value>(),
        "curves": (0..KEYS).map(curve).collect::<Value>(),
        "checked": work.checked.iter().map(checked).collect::<Value>(),
        "largest_difference_g": worst(work.checked),
    })
}
