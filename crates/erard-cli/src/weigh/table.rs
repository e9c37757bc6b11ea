//! The work as CSV and JSON.

use erard::keyboard::{KEYS, note_name};
use erard_workshop::balance::{BalancedKey, Bound, Checked, Lead, LeadWork, MeasuredKey, Remedy, Withheld};
use erard_workshop::digits::signed;
use erard_workshop::worklist::{AimFrom, KeyLine, KeyboardList, Leverage, Operation, Why, Work as Works};
use serde_json::{Value, json};

use super::{Work, remedy_text};
use crate::table::Table;

/// What the sample says of statics.
pub(super) fn checked_lines(work: &Work<'_>) -> Vec<String> {
    let worst = worst(work.checked).map(|worst| {
        format!("The dynamic model and the equation of balance differ by {worst:.2} g at most in that sample.")
    });
    work.checked.iter().map(|one| checked_text(one, work)).chain(worst).collect()
}

/// The largest difference of model and equation, g.
fn worst(checked: &[Checked]) -> Option<f64> {
    checked.iter().filter_map(|one| Some((one.in_model_g? - one.by_equation_g).abs())).reduce(f64::max)
}

fn checked_text(one: &Checked, work: &Work<'_>) -> String {
    let what = remedy_text(&one.remedy, work.lengths);
    let model = one.in_model_g.map_or("no weight moves the key".to_owned(), |g| format!("{} g", signed(g, 1)));
    format!(
        "Checked, {}: {what}: balance weight {} g by the equation, {model} in the model.",
        note_name(one.key),
        signed(one.by_equation_g, 1)
    )
}

/// weigh.csv: a row for every key that was weighed.
pub(crate) fn table(work: &Work<'_>) -> Table<'static> {
    type Number = (&'static str, fn(&BalancedKey) -> Option<f64>);
    const WEIGHED: [Number; 14] = [
        ("strike_weight_g", |key| key.measured.strike_weight_g),
        ("front_weight_g", |key| key.measured.front_weight_g),
        ("down_weight_g", |key| key.measured.down_weight_g),
        ("up_weight_g", |key| key.measured.up_weight_g),
        ("balance_weight_g", |key| key.balance_weight_g),
        ("friction_weight_g", |key| key.friction_weight_g),
        ("usual_friction_from_g", |key| Some(KeyboardList::usual_friction_g(key.measured.key)[0])),
        ("usual_friction_to_g", |key| Some(KeyboardList::usual_friction_g(key.measured.key)[1])),
        ("friction_is_out", |key| Some(f64::from(u8::from(KeyboardList::is_friction_out(key))))),
        ("ratio", |key| key.ratio),
        ("inertia_kg", |key| key.inertia_kg),
        ("from_curves", |key| Some(f64::from(u8::from(key.from_curves)))),
        ("target_strike_weight_g", |key| key.target_strike_weight_g),
        ("target_front_weight_g", |key| key.target_front_weight_g),
    ];
    const WORK: [Number; 5] = [
        ("strike_weight_change_g", |key| key.strike_change_g),
        ("capstan_to_the_player_mm", |key| key.capstan_move_mm),
        ("assist_g", |key| key.measured.assist_g),
        ("assist_change_g", |key| key.assist_change_g),
        ("down_weight_without_assist_g", without_assist_g),
    ];
    // What is to be weighed again first has no weights to come.
    const AFTER: [Number; 2] = [
        ("balance_weight_after_g", |key| key.after_balance_weight_g),
        ("inertia_after_kg", |key| key.after_inertia_kg),
    ];
    let keys = &work.list.plan.keys;
    let rounded = |value: Option<f64>| value.map(|x| (x * 1e4).round() / 1e4);
    let numbers =
        |table: Table<'static>, (name, get): Number| table.optional(name, keys.iter().map(|key| rounded(get(key))));
    let after = |table: Table<'static>, (name, get): Number| {
        table.optional(name, keys.iter().map(|key| rounded(get(key).filter(|_| !work.list.waits(key)))))
    };
    let leads = |of: fn(&LeadWork) -> &Vec<Lead>| {
        let list = |key: &BalancedKey| {
            let each = key
                .leads
                .iter()
                .flat_map(|leads| of(&leads.work))
                .map(|lead| format!("{}@{}", lead.mass_g, lead.at_mm));
            each.collect::<Vec<_>>().join(" ")
        };
        keys.iter().map(list).collect::<Vec<_>>()
    };
    let start = Table::default()
        .optional("key", keys.iter().map(|key| Some(key.measured.key as f64)))
        .words("note", keys.iter().map(|key| key.note.clone()));
    let apart = |key: &BalancedKey| key.apart.iter().map(|apart| apart.quantity).collect::<Vec<_>>().join(" ");
    let weighed = WEIGHED.into_iter().fold(start, numbers).words("sticks_out", keys.iter().map(apart));
    let led = weighed.words("leads_out", leads(|work| &work.out)).words("leads_in", leads(|work| &work.put));
    AFTER.into_iter().fold(WORK.into_iter().fold(led, numbers), after)
}

/// again.csv: the keys weighed again, with the columns that `--measured` reads.
pub(crate) fn again(keys: &[MeasuredKey]) -> Table<'static> {
    type Number = (&'static str, fn(&MeasuredKey) -> Option<f64>);
    const WEIGHED: [Number; 9] = [
        ("strike_weight_g", |key| key.strike_weight_g),
        ("front_weight_g", |key| key.front_weight_g),
        ("down_weight_g", |key| key.down_weight_g),
        ("up_weight_g", |key| key.up_weight_g),
        ("whippen_weight_g", |key| key.whippen_weight_g),
        ("key_ratio", |key| key.key_ratio),
        ("assist_g", |key| key.assist_g),
        ("aftertouch_mm", |key| key.aftertouch_mm),
        ("dip_mm", |key| key.dip_mm),
    ];
    let start = Table::default().optional("key", keys.iter().map(|key| Some(key.key as f64)));
    let rounded = |value: Option<f64>| value.map(|x| (x * 1e4).round() / 1e4);
    let weighed = WEIGHED
        .into_iter()
        .fold(start, |table, (name, get)| table.optional(name, keys.iter().map(|key| rounded(get(key)))));
    let leads = |key: &MeasuredKey| {
        key.leads.iter().map(|lead| format!("{}@{}", lead.mass_g, lead.at_mm)).collect::<Vec<_>>().join(" ")
    };
    weighed.words("leads", keys.iter().map(leads))
}

/// weigh.json.
pub(crate) fn report(work: &Work<'_>) -> Value {
    let (list, curves) = (work.list, &work.list.plan.curves);
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
            Remedy::Assist(_) => "assist",
        };
        json!({
            "key": one.key,
            "remedy": remedy,
            "balance_weight_by_equation_g": one.by_equation_g,
            "balance_weight_in_model_g": one.in_model_g,
        })
    };
    let aim_from = match list.aim_from {
        AimFrom::Asked => "asked",
        AimFrom::Median => "median",
        AimFrom::NearMedian => "near_median",
        AimFrom::Trade => "trade",
    };
    json!({
        "keyboard": work.name,
        "measured": work.file,
        "target_balance_weight_g": list.plan.target.balance_weight_g,
        "target_from": aim_from,
        "leverage": list.leverage.as_ref().map(of_leverage),
        "target_inertia_kg": list.plan.target.inertia_kg,
        "hammers_first": list.plan.target.hammers,
        "keys": list.plan.keys.iter().map(|key| of_key(key, list.waits(key))).collect::<Value>(),
        "work": list.lines.iter().map(of_line).collect::<Value>(),
        "waits": list.left.iter().map(|(key, why)| json!({"key": key, "why": why_word(why)})).collect::<Value>(),
        "curves": (0..KEYS).map(curve).collect::<Value>(),
        "checked": work.checked.iter().map(checked).collect::<Value>(),
        "largest_difference_g": worst(work.checked),
        "again": work.again.map(|again| again.iter().map(of_measured).collect::<Value>()),
    })
}

fn why_word(why: &Why) -> &'static str {
    match why {
        Why::Ceiling => "front_weight_ceiling",
        Why::Leverage => "leverage_first",
        _ => "friction_first",
    }
}

fn of_leverage(out: &Leverage) -> Value {
    json!({
        "keys": out.keys,
        "of": out.of,
        "smallest_ratio": out.ratios[0],
        "largest_ratio": out.ratios[1],
        "aim": out.aim,
        "capstan_to_the_player_mm": out.capstan_move_mm,
        "ratio_after": out.reaches,
    })
}

fn of_withheld(one: &Withheld) -> Value {
    let (remedy, amount) = match one.remedy {
        Remedy::Leads(_) => ("leads", None),
        Remedy::Strike(by_g) => ("strike_weight", Some(by_g)),
        Remedy::Capstan(by_mm) => ("capstan", Some(by_mm)),
        Remedy::Assist(by_g) => ("assist", Some(by_g)),
    };
    let why = match one.bound {
        Bound::Heel => "too_far",
        Bound::StrikeWeight(_) => "strike_weight_out",
        Bound::Aftertouch(_) => "aftertouch_out",
        Bound::Assist(_) => "assist_out",
        Bound::Model(_) => "model_differs",
        Bound::AsChecked => "model_differs_at_a_checked_key",
    };
    json!({"remedy": remedy, "amount": amount, "why": why})
}

fn of_leads(work: &LeadWork) -> Value {
    let pairs = |leads: &[Lead]| leads.iter().map(|lead| json!([lead.mass_g, lead.at_mm])).collect::<Value>();
    json!({
        "out": pairs(&work.out),
        "put": pairs(&work.put),
        "front_weight_g": work.front_weight_g,
        "inertia_g": work.inertia_g,
    })
}

fn of_key(key: &BalancedKey, waits: bool) -> Value {
    let apart = key.apart.iter().map(|apart| json!({"quantity": apart.quantity, "neighbours": apart.neighbours}));
    json!({
        "key": key.measured.key,
        "note": key.note,
        "down_weight_g": key.measured.down_weight_g,
        "up_weight_g": key.measured.up_weight_g,
        "balance_weight_g": key.balance_weight_g,
        "friction_weight_g": key.friction_weight_g,
        "usual_friction_g": KeyboardList::usual_friction_g(key.measured.key),
        "friction_is_out": KeyboardList::is_friction_out(key),
        "friction_is_doubtful": KeyboardList::is_friction_doubtful(key),
        "sticks_out": apart.collect::<Value>(),
        "ratio": key.ratio,
        "inertia_kg": key.inertia_kg,
        "from_curves": key.from_curves,
        "key_ratio": key.key_ratio,
        "whippen_weight_g": key.whippen_weight_g,
        "target_strike_weight_g": key.target_strike_weight_g,
        "target_front_weight_g": key.target_front_weight_g,
        "withheld": key.withheld.iter().map(of_withheld).collect::<Value>(),
        "strike_weight_change_g": key.strike_change_g,
        "capstan_to_the_player_mm": key.capstan_move_mm,
        "assist_g": key.measured.assist_g,
        "assist_change_g": key.assist_change_g,
        "down_weight_without_assist_g": without_assist_g(key),
        "balance_weight_after_g": key.after_balance_weight_g.filter(|_| !waits),
        "inertia_after_kg": key.after_inertia_kg.filter(|_| !waits),
    })
}

/// Down-weight with the springs unhooked or the magnets out, g: what they take off is in D.
fn without_assist_g(key: &BalancedKey) -> Option<f64> {
    Some(key.measured.down_weight_g? + key.measured.assist_g?)
}

fn of_line(line: &KeyLine) -> Value {
    let operation = match line.operation {
        Operation::Friction => "friction",
        Operation::Hammers => "hammers",
        Operation::Leads => "leads",
    };
    let leads = |works: &Works| match works {
        Works::Leads(leads) => Some(of_leads(leads)),
        _ => None,
    };
    json!({
        "operation": operation,
        "key": line.key,
        "note": note_name(line.key),
        "is_sample": line.is_sample,
        "by_g": line.work.amount(),
        "leads": leads(&line.work),
        "adding_instead": line.instead.as_ref().and_then(leads),
        "then": {
            "strike_weight_g": line.after.strike_g,
            "front_weight_g": line.after.front_g,
            "down_weight_g": line.after.down_g,
            "up_weight_g": line.after.up_g,
        },
    })
}

fn of_measured(key: &MeasuredKey) -> Value {
    json!({
        "key": key.key,
        "strike_weight_g": key.strike_weight_g,
        "front_weight_g": key.front_weight_g,
        "down_weight_g": key.down_weight_g,
        "up_weight_g": key.up_weight_g,
    })
}
