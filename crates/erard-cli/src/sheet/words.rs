//! A list of work in the words of the bench.

use erard_workshop::measure::Sheet;
use erard_workshop::regulate::{Handwork, known_screw, turns_text};
use erard_workshop::worklist::{Item, Left, ReadingQuantity, Readings, Why, Work, Worklist};

use super::{AdvisedInstrument, Task};
use crate::measure::headlines::READ_AGAIN;
use crate::table::decimal;
use crate::units::Lengths;

/// How the list is worked through.
pub(crate) const ORDER: &str = "each line after the ones before it, until it reads what the line says";

/// What to do, in the order of work.
pub(crate) fn tasks(one: &AdvisedInstrument<'_>) -> Vec<Task> {
    let list = &one.list;
    let mut tasks: Vec<Task> = list.items.iter().map(|item| task(item, one)).collect();
    if let Some(task) = list.aftertouch_is_decided_by().and_then(|last| tasks.get_mut(last)) {
        let read = "read the aftertouch; if it is out of its range, correct it by paper as far as the dip allows, then by the capstan";
        task.then = Some(read.to_owned());
    }
    tasks
}

/// What to do after the last line, if screws were turned: they move each other.
pub(crate) fn in_the_end(list: &Worklist) -> Option<&'static str> {
    let has_turned = list.items.iter().any(|item| matches!(item.work, Work::Screw { .. }));
    let again = "read the distances once more; set what is out of its range by its own screw, unless the list says why it cannot come in";
    has_turned.then_some(again)
}

/// What the list leaves: its quantity, and why, a line each.
pub(crate) struct LeftLine {
    pub(crate) quantity: ReadingQuantity,
    pub(crate) why: String,
}

/// What the list leaves under a heading.
pub(crate) fn left(list: &Worklist, heading: &str, lengths: Lengths) -> Vec<LeftLine> {
    let line = |left: &Left| {
        let quantity = left.quantity;
        let reads = reading(quantity, &list.after, lengths);
        let reads = match (left.why.is_read_again(), list.after.get(quantity)) {
            (true, None) => String::new(),
            (true, Some(_)) => format!(", perhaps {reads}"),
            (false, _) => format!(" {reads}"),
        };
        LeftLine { quantity, why: format!("{}{reads}: {}", name(quantity), why_words(quantity, &left.why)) }
    };
    list.left.iter().filter(|left| left.why.is_read_again() == (heading == READ_AGAIN)).map(line).collect()
}

/// What is out of its range and no line of work is for, with what it comes from: a line each. Other readings of the
/// same weight are left out.
pub(crate) fn beyond(sheet: &Sheet) -> Vec<String> {
    let is_worked_on = |key: &str| {
        const READ_OTHERWISE: [&str; 2] = ["by_slow_loop.", "dampers_down."];
        ReadingQuantity::ALL.iter().any(|quantity| quantity.key() == key)
            || READ_OTHERWISE.iter().any(|other| key.starts_with(other))
    };
    let others = sheet.flags.iter().filter(|flag| !is_worked_on(flag.key));
    others.map(|flag| format!("{}; {}", flag.message, comes_from(flag.key))).collect()
}

/// What decides a line that no line of work is for.
fn comes_from(key: &str) -> &'static str {
    match key {
        "whippen_weight_g" => "no screw changes it: weigh it off the key, and compare its neighbours",
        "key_ratio" => "the key's wood and the capstan's place decide it",
        "double_strike_m_per_s" => "back check, repetition spring and lever decide it: measure again after this list",
        "repetition_rate_hz" | "repetition_rate_half_hz" => {
            "friction, spring and check decide it: measure again after this list"
        }
        _ if key.starts_with("effective_inertia") => {
            "lighter hammers, less leverage or less lead bring it down: measure again after this list"
        }
        _ => "this list has no line for it: measure again afterwards",
    }
}

fn task(item: &Item, one: &AdvisedInstrument<'_>) -> Task {
    let lengths = one.lengths;
    let from_to = format!(
        "{} from {} to {}",
        name(item.quantity),
        reading(item.quantity, &item.before, lengths),
        reading(item.quantity, &item.after, lengths)
    );
    let for_ = match item.work {
        Work::FrontWeight { .. } | Work::Hammer { .. } => {
            let weight = |quantity| reading(quantity, &item.after, lengths);
            format!("{from_to}; D {}, U {}", weight(ReadingQuantity::DownWeight), weight(ReadingQuantity::UpWeight))
        }
        _ => from_to,
    };
    Task {
        what: what(&item.work),
        by: how_far(item, &one.list, lengths),
        for_,
        then: None,
        instead: item.instead.as_ref().map(|work| {
            let instead = Item { work: work.clone(), ..item.clone() };
            format!("{}: {}", what(work), how_far(&instead, &one.list, lengths))
        }),
        readings: readings(&item.after),
    }
}

/// Every reading, by the sheet's keys.
pub(super) fn readings(readings: &Readings) -> serde_json::Value {
    let value = |quantity: ReadingQuantity| (quantity.key().to_owned(), readings.get(quantity).into());
    serde_json::Value::Object(ReadingQuantity::ALL.into_iter().map(value).collect())
}

/// A reading with its unit.
pub(super) fn reading(quantity: ReadingQuantity, readings: &Readings, lengths: Lengths) -> String {
    crate::measure::shown(quantity.line(), readings.get(quantity), lengths)
}

/// What the bench calls a line.
pub(super) fn name(quantity: ReadingQuantity) -> &'static str {
    match quantity {
        ReadingQuantity::DownWeight => "down-weight",
        ReadingQuantity::UpWeight => "up-weight",
        ReadingQuantity::BalanceWeight => "balance weight",
        ReadingQuantity::FrictionWeight => "friction",
        ReadingQuantity::StrikeWeight => "strike weight",
        ReadingQuantity::FrontWeight => "front weight",
        ReadingQuantity::Ratio => "leverage",
        ReadingQuantity::Dip => "dip",
        ReadingQuantity::Blow => "blow",
        ReadingQuantity::JackPosition => "jack position",
        ReadingQuantity::LeverHeight => "lever height",
        ReadingQuantity::LetOff => "let-off",
        ReadingQuantity::Drop => "drop",
        ReadingQuantity::Aftertouch => "aftertouch",
        ReadingQuantity::Check => "check",
        ReadingQuantity::Spring => "rise from the check",
        ReadingQuantity::Damper => "damper start",
    }
}

/// What is worked on.
fn what(work: &Work) -> String {
    match work {
        Work::Friction { .. } => "friction",
        Work::Capstan { .. } => "capstan line",
        Work::Hammer { .. } => "hammer",
        Work::Leads(_) | Work::FrontWeight { .. } => "key leads",
        Work::Screw { name, .. } => return screw_words(name),
    }
    .to_owned()
}

/// What the weights on the key read after a line.
fn weighed(item: &Item) -> String {
    let [down, up] = item.weighed_g().map_or([None; 2], |both| both.map(Some)).map(|g| decimal(g, 0));
    format!("D is {down} g and U {up} g")
}

/// How far, in steps that a hand can do and a scale can show.
fn how_far(item: &Item, list: &Worklist, lengths: Lengths) -> String {
    let (amount, instrument) = (item.work.amount(), &list.copy);
    match &item.work {
        // Until the weights read it, in whole grams: nobody feels by how many grams a pin was eased.
        Work::Friction { by_g } if *by_g < 0.0 => {
            format!("ease it until {} (key bushings, centre pins, knuckle)", weighed(item))
        }
        Work::Friction { by_g } => {
            format!("{by_g:.0} g too little: are the centre pins loose? Weigh again before you go on")
        }
        Work::Hammer { by_g } => crate::weigh::hammer_text(*by_g),
        Work::Capstan { by_mm } => {
            format!("move it {} {}", lengths.text(by_mm.abs(), 1), item.work.way(instrument))
        }
        Work::Leads(leads) if leads.put.is_empty() => crate::weigh::leads_text(leads, lengths),
        // A lead is tried where it can still be shifted.
        Work::Leads(leads) => {
            let it = if leads.put.len() == 1 { "it" } else { "them" };
            let leads = crate::weigh::leads_text(leads, lengths);
            let most = match item.room_to_shift_mm(list.key, front_mm(instrument)) {
                Some(0.0) => ", but no farther out".to_owned(),
                Some(most_mm) => format!(", but at most {} farther out", lengths.text(most_mm, 0)),
                None => String::new(),
            };
            format!("{leads}; before you drill, lay {it} on the key and shift {it} until {}{most}", weighed(item))
        }
        Work::FrontWeight { by_g } => crate::weigh::front_weight_text(*by_g, front_mm(instrument), lengths),
        Work::Screw { name, by } => {
            let way = item.work.way(instrument);
            match known_screw(name).map(|known| known.work) {
                Some(Handwork::Thread(pitch_m)) => format!("{} {way}", turns_text(by / pitch_m)),
                Some(Handwork::Layers) if way == "up" => format!("put {} under", lengths.text(amount.abs() * 1e3, 1)),
                Some(Handwork::Layers) => format!("take {} out", lengths.text(amount.abs() * 1e3, 1)),
                Some(Handwork::Bent) if *name == "repetition_spring" => {
                    format!("bend it {way} by {:.1} N mm at its arm", amount.abs() * 1e3)
                }
                Some(Handwork::Bent) if *name == "back_check_angle" => {
                    format!("tilt it {:.0}° ({way})", amount.abs().to_degrees())
                }
                // A wire is bent until the hammer is caught where it should be: nobody sees how far it went.
                Some(Handwork::Bent) if item.quantity == ReadingQuantity::Check => {
                    let caught = format!("bend it {way} until it catches the hammer");
                    let at = reading(ReadingQuantity::Check, &item.after, lengths);
                    match [&item.before, &item.after].map(|readings| readings.get(ReadingQuantity::Check)) {
                        [Some(before), Some(after)] if after > before => {
                            format!("{caught} at {at}, or as near to that as it still catches")
                        }
                        [_, Some(_)] => format!("{caught} at {at}"),
                        [_, None] => caught,
                    }
                }
                Some(Handwork::Bent) => format!("bend it {} {way}", lengths.text(amount.abs() * 1e3, 1)),
                Some(Handwork::Stack) | None => format!("{} {way}", lengths.text(amount.abs() * 1e3, 1)),
            }
        }
    }
}

fn front_mm(instrument: &erard::instrument::Instrument) -> f64 {
    1e3 * instrument.roles.key_front_m[0].abs()
}

/// What the bench calls a screw of the file.
fn screw_words(name: &str) -> String {
    known_screw(name).map_or_else(|| name.replace('_', " "), |known| known.part.to_owned())
}

fn why_words(quantity: ReadingQuantity, why: &Why) -> String {
    let screws = |names: &[&'static str]| names.iter().map(|name| screw_words(name)).collect::<Vec<_>>().join(", ");
    match why {
        Why::TooFine => "the correction is less than a hand can do or a scale can show".to_owned(),
        Why::EndOfRange(names) => format!("at the end of its range: {}", screws(names)),
        Why::NoSetting(names) => format!("no setting of {} gives it", screws(names)),
        Why::NoScrew => "no screw in this file; set it by hand".to_owned(),
        Why::Friction => "friction must come right first".to_owned(),
        Why::Leverage => "leverage must come right first".to_owned(),
        Why::ReadAgain if quantity.has_screw() => {
            "other lines change it by an uncertain amount; read it in the end, and set it if it is out".to_owned()
        }
        Why::ReadAgain => "other lines change it by an uncertain amount; read it again after this list".to_owned(),
        Why::Unreadable if [ReadingQuantity::Check, ReadingQuantity::Spring].contains(&quantity) => {
            "it cannot be read before the check catches the hammer; measure again after this list".to_owned()
        }
        Why::Unreadable => "it cannot be known before the hammer drops; measure again after this list".to_owned(),
        Why::NoRoom => {
            "no dip brings blow and aftertouch into their ranges together: look at the back rail cloth, and at the key's \
             height"
                .to_owned()
        }
        Why::NoBalance => {
            "with this friction no balance weight brings both down-weight and up-weight into range".to_owned()
        }
        Why::Ceiling => "the key carries as much lead as it should; use lighter hammers or less leverage".to_owned(),
        Why::Follows if quantity == ReadingQuantity::FrontWeight => {
            "above its ceiling, and the weights leave no room for less lead: use lighter hammers or less leverage"
                .to_owned()
        }
        _ => "it follows from the lines above".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use erard::instrument::Instrument;
    use erard_workshop::balance::{Lead, LeadWork};

    use super::*;

    /// What the list cannot know is read again; what stays out of its range does so for a reason.
    #[test]
    fn what_is_read_again_does_not_stay_out() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mut before = Readings::of(&grand, &mut |_| true).unwrap();
        before.set(ReadingQuantity::Drop, Some(2.7));
        before.set(ReadingQuantity::FrontWeight, Some(32.2));
        before.set(ReadingQuantity::Aftertouch, None);
        let of = |quantity: ReadingQuantity, why: Why| Left { quantity, why };
        let left_lines = vec![
            of(ReadingQuantity::Drop, Why::ReadAgain),
            of(ReadingQuantity::Aftertouch, Why::Unreadable),
            of(ReadingQuantity::FrontWeight, Why::Follows),
        ];
        let list = Worklist { key: 40, before, items: vec![], after: before, left: left_lines, copy: grand };
        let said = |heading: &str| -> Vec<String> {
            left(&list, heading, Lengths::default()).into_iter().map(|line| line.why).collect()
        };
        let [again, out] = [READ_AGAIN, crate::measure::headlines::STAYS_OUT].map(said);
        assert_eq!((again.len(), out.len()), (2, 1), "{again:?} {out:?}");
        assert!(again[0].starts_with("drop, perhaps 2.7 mm: other lines change it"), "{again:?}");
        assert!(again[1].starts_with("aftertouch: it cannot be known before"), "{again:?}");
        assert!(out[0].starts_with("front weight 32.2 g: above its ceiling"), "{out:?}");
    }

    /// Work that a hand does until something reads right says what reads how, in whole grams: friction and leads by the
    /// weights on the key, but no farther than the front weight's ceiling, a check by where it catches the hammer, or
    /// as near to that as it does.
    #[test]
    fn work_is_done_until_a_reading() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mut before = Readings::of(&grand, &mut |_| true).unwrap();
        before.set(ReadingQuantity::FrontWeight, Some(20.0));
        before.set(ReadingQuantity::Check, Some(15.0));
        let mut after = before;
        after.set(ReadingQuantity::DownWeight, Some(48.6));
        after.set(ReadingQuantity::UpWeight, Some(25.4));
        after.set(ReadingQuantity::Check, Some(13.14));
        let list = Worklist { key: 40, before, items: vec![], after, left: vec![], copy: grand };
        let said = |quantity: ReadingQuantity, work: Work, after: Readings| {
            how_far(&Item { quantity, work, instead: None, before, after }, &list, Lengths::default())
        };
        let friction = said(ReadingQuantity::FrictionWeight, Work::Friction { by_g: -4.3 }, after);
        assert_eq!(friction, "ease it until D is 49 g and U 25 g (key bushings, centre pins, knuckle)");
        let lead = |at_mm: f64| Lead { mass_g: 14.0, at_mm };
        let moved = LeadWork { out: vec![lead(164.0)], put: vec![lead(120.0)], ..Default::default() };
        let leads = said(ReadingQuantity::BalanceWeight, Work::Leads(moved.clone()), after);
        let once = "move 14 g from 164 mm to 120 mm";
        assert_eq!(
            leads,
            format!("{once}; before you drill, lay it on the key and shift it until D is 49 g and U 25 g")
        );
        // 14 g at the key's front are 14 g of front weight: 0.7 g under the ceiling are a twentieth of its front arm.
        let ceiling_g = ReadingQuantity::FrontWeight.line().range(list.key)[1].unwrap();
        after.set(ReadingQuantity::FrontWeight, Some(ceiling_g - 0.7));
        let near = said(ReadingQuantity::BalanceWeight, Work::Leads(moved.clone()), after);
        let most_mm = (0.05 * front_mm(&list.copy)).floor();
        assert_eq!(near, format!("{leads}, but at most {most_mm} mm farther out"));
        after.set(ReadingQuantity::FrontWeight, Some(ceiling_g));
        let at_the_ceiling = said(ReadingQuantity::BalanceWeight, Work::Leads(moved.clone()), after);
        assert_eq!(at_the_ceiling, format!("{leads}, but no farther out"));
        // A lead that comes out is not laid anywhere.
        let out = said(ReadingQuantity::BalanceWeight, Work::Leads(LeadWork { put: vec![], ..moved }), after);
        assert_eq!(out, "out 14 g at 164 mm");
        let wire = Work::Screw { name: "back_check", by: 3e-4 };
        let check = said(ReadingQuantity::Check, wire.clone(), after);
        assert!(check.ends_with("until it catches the hammer at 13.1 mm"), "{check}");
        after.set(ReadingQuantity::Check, Some(16.0));
        let farther = said(ReadingQuantity::Check, wire.clone(), after);
        let nearest = "until it catches the hammer at 16.0 mm, or as near to that as it still catches";
        assert!(farther.ends_with(nearest), "{farther}");
        after.set(ReadingQuantity::Check, None);
        let caught = said(ReadingQuantity::Check, wire, after);
        assert!(caught.ends_with("until it catches the hammer"), "{caught}");
    }
}
