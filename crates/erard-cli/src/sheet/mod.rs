//! The technician's sheet: one printed page of an action, in the words of the bench.

mod page;

pub(crate) use page::html;

use erard_workshop::advice::{Advice, WeightWork};
use erard_workshop::regulate::{Achieved, Goal, Handwork, Turned, known_screw, turns_text};

use crate::measure::Measured;
use crate::paper::Headed;
use crate::units::Lengths;

/// An action with what to do about it.
#[derive(Debug)]
pub(crate) struct Advised<'a> {
    /// The action, and what was measured.
    pub measured: &'a Measured,
    /// What to do.
    pub advice: Advice,
    /// A drawing of it.
    pub drawing: &'a str,
    /// What stands at the head.
    pub headed: &'a Headed,
    /// How lengths are shown.
    pub lengths: Lengths,
}

/// One thing to do: what, how far, and why.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(crate) struct Task {
    /// What is worked on: `drop screw`.
    pub what: String,
    /// Which way and how far.
    pub by: String,
    /// What it does.
    #[serde(rename = "for")]
    pub for_: String,
}

/// What to do, in the order of work.
pub(crate) fn tasks(one: &Advised<'_>) -> Vec<Task> {
    let mut tasks: Vec<Task> = one.advice.weights.iter().map(|work| weight_task(work, one.lengths)).collect();
    if let Some(regulated) = &one.advice.regulated {
        for turned in &regulated.turned {
            let served =
                regulated.achieved.iter().find(|a| a.goal.screws().iter().any(|(name, _)| *name == turned.name));
            tasks.push(screw_task(turned, served, &one.advice.out, one.lengths));
        }
        for missed in regulated.achieved.iter().filter(|a| a.miss.is_some() && one.advice.out.contains(&a.goal)) {
            let nearest = missed.after.map_or("it does not happen".to_owned(), |after| {
                format!("{} is the nearest", crate::regulate::shown_value(missed.goal, after, one.lengths))
            });
            tasks.push(Task {
                what: missed.goal.name().to_owned(),
                by: "out of reach of its screw".to_owned(),
                for_: nearest,
            });
        }
    }
    for goal in &one.advice.out {
        let tried = one.advice.regulated.iter().flat_map(|r| &r.achieved).any(|achieved| achieved.goal == *goal);
        if !tried {
            tasks.push(Task {
                what: goal.name().to_owned(),
                by: "no screw in this file".to_owned(),
                for_: "set it by hand".to_owned(),
            });
        }
    }
    let flagged = |key: &str| one.measured.sheet.flags.iter().any(|flag| flag.key == key);
    if flagged("aftertouch_mm") && one.advice.regulated.is_none() {
        tasks.push(Task {
            what: "aftertouch".to_owned(),
            by: "nothing to turn by itself".to_owned(),
            for_: "it follows from dip, blow and leverage".to_owned(),
        });
    }
    tasks
}

/// sheet.json.
pub(crate) fn report(one: &Advised<'_>) -> serde_json::Value {
    let (sheet, headed) = (&one.measured.sheet, one.headed);
    let mut out: Vec<&str> = sheet.flags.iter().map(|flag| flag.key).collect();
    out.dedup();
    serde_json::json!({
        "instrument": one.measured.label,
        "norms_for_key": sheet.norms_for_key,
        "serial": headed.serial,
        "date": headed.date,
        "note": headed.note,
        "out_of_the_norm": out,
        "tasks": tasks(one),
    })
}

fn screw_task(turned: &Turned, served: Option<&Achieved>, out: &[Goal], lengths: Lengths) -> Task {
    let by = turned.setting[1] - turned.setting[0];
    let mm = by.abs() * 1e3;
    let far = match known_screw(&turned.name).map(|known| known.work) {
        Some(Handwork::Thread(pitch_m)) => {
            format!("{} {}: {}", lengths.text(mm, 2), turned.way, turns_text(by / pitch_m))
        }
        Some(Handwork::Layers) if turned.way == "up" => format!("put {} of punchings under", lengths.text(mm, 2)),
        Some(Handwork::Layers) => format!("take {} of punchings out", lengths.text(mm, 2)),
        Some(Handwork::Bent) if turned.name == "repetition_spring" => {
            format!("bend it {} by {:.1} N mm at its arm", turned.way, by.abs() * 1e3)
        }
        Some(Handwork::Bent) if turned.name == "back_check_angle" => {
            format!("tilt it {:.1}° ({})", by.abs().to_degrees(), turned.way)
        }
        Some(Handwork::Bent) => format!("bend it {} {}", lengths.text(mm, 2), turned.way),
        Some(Handwork::Stack) | None => format!("{} {}", lengths.text(mm, 2), turned.way),
    };
    let for_ = served.map_or(String::new(), |achieved| {
        let value = |value: Option<f64>| {
            value.map_or("none".to_owned(), |v| crate::regulate::shown_value(achieved.goal, v, lengths))
        };
        if out.contains(&achieved.goal) {
            format!("{} from {} to {}", achieved.goal.name(), value(achieved.before), value(achieved.after))
        } else {
            format!("follows: keeps {} at {}", achieved.goal.name(), value(achieved.after))
        }
    });
    Task { what: screw_words(&turned.name), by: far, for_ }
}

/// What the bench calls a screw of the file.
fn screw_words(name: &str) -> String {
    match name {
        "capstan_height" => "capstan",
        "let_off" => "let-off button",
        "drop" => "drop screw",
        "repetition_spring" => "repetition spring",
        "jack_position" => "jack screw",
        "lever_height" => "repetition lever screw",
        "back_check" => "back check",
        "back_check_angle" => "back check, angle",
        "front_punching" => "front punchings",
        "back_rail_cloth" => "back rail cloth",
        "string_height" => "action height",
        "damper_timing" => "damper lift",
        other => return other.replace('_', " "),
    }
    .to_owned()
}

fn weight_task(work: &WeightWork, lengths: Lengths) -> Task {
    let task = |what: &str, by: String, for_: String| Task { what: what.to_owned(), by, for_ };
    match work {
        WeightWork::Ease(by_g) => task(
            "friction",
            format!("ease it by {by_g:.1} g"),
            "key bushings, centre pins, knuckle; then weigh again".to_owned(),
        ),
        WeightWork::Tighten(by_g) => {
            task("friction", format!("{by_g:.1} g too little"), "loose centre pins? then weigh again".to_owned())
        }
        WeightWork::Hammer(by_g) if *by_g < 0.0 => {
            task("hammer", format!("take {:.1} g off", -by_g), "to the heaviest that is usual here".to_owned())
        }
        WeightWork::Hammer(by_g) => {
            task("hammer", format!("add {by_g:.1} g"), "to the lightest that is usual here".to_owned())
        }
        WeightWork::Capstan(by_mm, ratio) => {
            let way = if *by_mm < 0.0 { "back" } else { "to the player" };
            task(
                "capstan line",
                format!("move it {} {way}", lengths.text(by_mm.abs(), 1)),
                format!("leverage to {ratio:.1}; regulate and weigh anew"),
            )
        }
        WeightWork::Leads(leads, target_g) => {
            let by = match leads {
                None => "not by leads alone".to_owned(),
                Some(leads) => crate::weigh::leads_text(leads, lengths),
            };
            task("key leads", by, format!("balance weight to {target_g:.0} g, as the key is now"))
        }
        _ => task("weights", String::new(), String::new()),
    }
}
