//! `erard regulate`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::InstrumentSpec;
use erard::parameter::aliases;
use erard::player::RestPose;
use erard_workshop::distances::{DistanceError, Protocol};
use erard_workshop::measure::range::{HARDLY_HEARD_M_PER_S, double_strike};
use erard_workshop::regulate::{
    Goal, RegulateError, Regulated, Specification, Status, disturbed, needed, parse_value, regulate, regulate_following,
};
use erard_workshop::worklist::{is_usual_aftertouch, regulate_to_aftertouch};
use serde_json::Value;

use super::options::{RestBefore, Stays};
use super::out::OwnFile;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::load_instrument_and_text;
use crate::output::Output;
use crate::print_line;
use crate::regulate::{
    Shown, aftertouch_report, aftertouch_text, misses, report, settled_text, shown_value, turned_text,
};
use crate::session::Session;
use crate::units::Lengths;
use crate::warn;

/// Text below the options.
const AFTER: &str = include_str!("help/regulate.txt");

/// Said where no goal was given and none is needed.
const NOTHING_TO_TURN: &str =
    "Every distance with a screw is in its usual range: nothing was turned. --norms turns all to the trade's norms.";

/// Turns an instrument's screws until its action meets a specification.
///
/// It works as on the bench: it measures by simulated trials, turns screws in the trade's order, and repeats the round
/// until every goal is met at once.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Regulate {
    /// Instrument: a TOML file, or a built-in name
    #[arg(value_name = "INSTRUMENT", default_value = "concert-grand")]
    instrument: InstrumentSpec,
    #[command(flatten)]
    goals: Goals,
    /// Set every distance without a goal to the trade's norm, even one in its usual range
    #[arg(long)]
    norms: bool,
    /// Turn other screws too, so that distances without a goal stay as they were
    #[arg(long)]
    follow: bool,
    /// Also bring the aftertouch into its usual range, and keep WHAT if not both can be kept
    #[arg(long, value_name = "WHAT", value_enum)]
    priority: Option<Stays>,
    /// How the action comes to rest before it is measured. --priority takes it as played
    #[arg(long, value_name = "REST", value_enum, default_value = "as-played")]
    rest: RestBefore,
    #[command(flatten)]
    lengths: Lengths,
    /// New instrument file [default: INSTRUMENT-regulated.toml in this folder]
    #[arg(long, value_name = "FILE")]
    out_file: Option<PathBuf>,
    /// Replace FILE and its report if they exist
    #[arg(long)]
    force: bool,
}

/// One option for each goal.
#[derive(Debug, Args)]
struct Goals {
    /// Key travel to the bottom
    #[arg(long, value_name = "10mm", allow_hyphen_values = true)]
    dip: Option<String>,
    /// Distance from hammer to string at rest
    #[arg(long, value_name = "46mm", allow_hyphen_values = true)]
    blow: Option<String>,
    /// Distance from hammer to string at let-off, on a slow key
    #[arg(long, aliases = aliases("let-off"), value_name = "1.5mm", allow_hyphen_values = true)]
    let_off: Option<String>,
    /// Fall of the hammer after let-off
    #[arg(long, value_name = "1.5mm", allow_hyphen_values = true)]
    drop: Option<String>,
    /// Distance from hammer to string in check, after a medium blow
    #[arg(long, value_name = "15mm", allow_hyphen_values = true)]
    check: Option<String>,
    /// Rise of the hammer when the key is let up from check
    #[arg(long, value_name = "12mm", allow_hyphen_values = true)]
    repetition_rise: Option<String>,
    /// Strength of the repetition spring: largest hammer speed in that rise
    #[arg(long, alias = "spring", value_name = "250mm/s", allow_hyphen_values = true)]
    repetition_spring: Option<String>,
    /// Distance from the middle of the knuckle to the rear edge of the jack's top
    #[arg(long, value_name = "1.5mm", allow_hyphen_values = true)]
    jack_position: Option<String>,
    /// Height of the repetition lever above the jack's top
    #[arg(long, value_name = "0.1mm", allow_hyphen_values = true)]
    lever_height: Option<String>,
    /// Key travel at which the damper starts to rise, as a share of the dip
    #[arg(long, alias = "damper", value_name = "50%", allow_hyphen_values = true)]
    damper_start: Option<String>,
}

impl Goals {
    fn text(&self, goal: Goal) -> (&'static str, Option<&str>) {
        let (option, text) = match goal {
            Goal::JackPosition => ("--jack-position", &self.jack_position),
            Goal::LeverHeight => ("--lever-height", &self.lever_height),
            Goal::Blow => ("--blow", &self.blow),
            Goal::Dip => ("--dip", &self.dip),
            Goal::LetOff => ("--let-off", &self.let_off),
            Goal::Drop => ("--drop", &self.drop),
            Goal::Check => ("--check", &self.check),
            Goal::RepetitionRise => ("--repetition-rise", &self.repetition_rise),
            Goal::RepetitionSpring => ("--repetition-spring", &self.repetition_spring),
            Goal::DamperStart => ("--damper-start", &self.damper_start),
        };
        (option, text.as_deref())
    }
}

impl Regulate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let given = self.specification()?;
        let (instrument, text) = load_instrument_and_text(session, &self.instrument)?;
        let (out, asked) = (self.out_file.as_deref(), self.instrument.to_string());
        let OwnFile { folder, name } =
            OwnFile::of(session, out, &asked, "-regulated.toml", "new instrument's", self.force)?;
        let report_name = Path::new(&name).with_extension("json").to_string_lossy().into_owned();
        let mut output = Output::files(session, &folder, self.force, &[&name, &report_name])?;

        let mut progress = session.progress("measuring");
        let mut tell = |status: &Status| {
            progress.say(&match status.goal {
                Some(goal) => format!("round {}, {}", status.round, goal.name()),
                None => "measuring".into(),
            });
            progress.tell(status.share)
        };
        let start = Instant::now();
        let found = RestPose::of(&instrument, self.rest.into(), &mut |_| true);
        let rest = found.map_err(|error| RegulateError::from(DistanceError::from(error)))?;
        let protocol = Protocol::default();
        // Nothing asked for: what is out of its usual range, and all else stays as it is.
        let (specification, follow) = match given {
            Some(given) => (given, self.follow),
            None => (needed(&rest, &protocol, &mut tell)?, true),
        };
        let work = if follow { regulate_following } else { regulate };
        let settled = self
            .priority
            .map(|stays| regulate_to_aftertouch(&instrument, &specification, stays.into(), follow, &mut tell));
        let settled = settled.transpose()?;
        let regulated = match &settled {
            Some(settled) => settled.regulated.clone(),
            None => work(&rest, &specification, &protocol, &mut tell)?,
        };
        // Where a goal is missed, whether it is met when other screws follow.
        let help = if regulated.all_met() || follow || settled.is_some() {
            None
        } else {
            let followed = regulate_following(&rest, &specification, &protocol, &mut tell)?;
            followed.all_met().then_some(followed)
        };
        progress.say("soft notes");
        let soft = {
            let mut measured = |instrument: &Instrument| {
                double_strike(instrument, &mut |_| progress.tell(0.99))
                    .map_err(|error| Failure::Measure { label: instrument.name.clone(), error: Box::new(error) })
            };
            [measured(&instrument)?, measured(&regulated.instrument)?]
        };
        let elapsed = start.elapsed();
        drop(progress);

        let new_text = regulated.rewrite(&text).map_err(|e| Failure::Internal(e.to_string()))?;
        let mut report = report(&regulated, soft, &asked, &name);
        if let (Some(settled), serde_json::Value::Object(report)) = (&settled, &mut report) {
            report.insert("aftertouch".into(), aftertouch_report(settled));
        }
        output.text(session, &name, &new_text)?;
        output.json(session, &report_name, &report)?;
        let written = output.commit(session)?;

        let answer = Answer::of(&report)?;
        print_line!(session, "{}", instrument.name);
        answer.begin(
            session,
            |answer| headlines(answer, &regulated, self.lengths),
            "every distance before and after, and how many simulations it took",
        );
        print_line!(
            session,
            "{} - regulated in {} {}, {} simulations, {:.1} s",
            instrument.name,
            regulated.rounds,
            if regulated.rounds == 1 { "round" } else { "rounds" },
            regulated.simulations,
            elapsed.as_secs_f64()
        );
        print_line!(session);
        print_line!(session, "{}", Shown(&regulated, self.lengths));
        if soft[1] > HARDLY_HEARD_M_PER_S {
            warn!(
                session,
                "warning: a soft note strikes twice, the second time at {:.2} m/s (before: {:.2} m/s): a weaker repetition spring (--repetition-spring) or a \
                 longer drop (--drop) helps",
                soft[1],
                soft[0]
            );
        }
        if specification.is_empty() && regulated.turned.is_empty() {
            print_line!(session, "{NOTHING_TO_TURN}");
            print_line!(session);
        }
        if !follow && regulated.all_met() {
            for line in moved(&regulated, self.lengths) {
                print_line!(session, "{line}");
            }
        }
        match &settled {
            Some(settled) => settled_text(settled, self.lengths).iter().for_each(|line| print_line!(session, "{line}")),
            None if !is_usual_aftertouch(&regulated.instrument, &regulated.after) => {
                print_line!(session, "{}", aftertouch_text(&regulated, self.lengths));
                print_line!(
                    session,
                    "To change that, add --priority dip (changes the blow) or --priority aftertouch (changes the dip first)."
                );
                print_line!(session);
            }
            None => {}
        }
        let answer = answer.end(session, &written);
        let unsettled = settled.as_ref().filter(|settled| !settled.is_settled);
        let unsettled = unsettled.map(|settled| {
            let [dip, blow] = [Goal::Dip, Goal::Blow].map(|goal| {
                let after = goal.of(&settled.regulated.after);
                after.map_or("none".to_owned(), |after| shown_value(goal, after, self.lengths))
            });
            let text = aftertouch_text(&settled.regulated, self.lengths);
            format!("{text}; dip ({dip}) and blow ({blow}) are at the ends of their usual ranges")
        });
        match [misses(&regulated), unsettled.into_iter().collect()].concat() {
            misses if misses.is_empty() => Ok(answer),
            mut misses => {
                misses.extend(help.map(|followed| must_follow(&specification, &followed, self.lengths)));
                Ok(answer.short_of(Some(misses.join("\n       "))))
            }
        }
    }

    /// The goals that were asked for; `None` without any.
    fn specification(&self) -> Result<Option<Specification>, Failure> {
        let mut specification = Vec::new();
        for goal in Goal::ALL {
            if let (option, Some(text)) = self.goals.text(goal) {
                let target = parse_value(goal, text)
                    .map_err(|expected| Failure::Usage(format!("{option} {text}: expected {expected}")))?;
                specification.push((goal, target));
            }
        }
        if self.norms {
            let given: Vec<Goal> = specification.iter().map(|(goal, _)| *goal).collect();
            specification.extend(Goal::norms().into_iter().filter(|(goal, _)| !given.contains(goal)));
        }
        Ok(Some(specification).filter(|specification| !specification.is_empty()))
    }
}

/// The first lines: which screws were turned and how far, and whether every goal is met.
fn headlines(answer: &Value, regulated: &Regulated, lengths: Lengths) -> Vec<String> {
    if regulated.turned.is_empty() {
        let goals = answer["goals"].as_array().map_or(0, Vec::len);
        return vec![if goals == 0 {
            NOTHING_TO_TURN.to_owned()
        } else {
            "Every goal is met as it is: nothing was turned.".to_owned()
        }];
    }
    let mut lines = vec![if answer["all_met"] == true {
        "Every goal is met. Turned:".to_owned()
    } else {
        "Not every goal is met. Turned:".to_owned()
    }];
    for achieved in &regulated.achieved {
        let shown =
            |value: Option<f64>| value.map_or("none".to_owned(), |value| shown_value(achieved.goal, value, lengths));
        let screws: Vec<String> =
            regulated.screws_of(achieved.goal).map(|turned| turned_text(turned, lengths)).collect();
        if !screws.is_empty() {
            let (before, after) = (shown(achieved.before), shown(achieved.after));
            lines.push(format!("  {}: {before} to {after}: {}", achieved.goal.name(), screws.join(", ")));
        }
    }
    lines
}

/// What the regulation moved though nobody asked, and how it comes back.
fn moved(regulated: &Regulated, lengths: Lengths) -> Vec<String> {
    let moved: Vec<String> = disturbed(regulated)
        .into_iter()
        .map(|(goal, before)| {
            let after = goal.of(&regulated.after).map_or("none".to_owned(), |after| shown_value(goal, after, lengths));
            format!("{} from {} to {after}", goal.name(), shown_value(goal, before, lengths))
        })
        .collect();
    if moved.is_empty() {
        return Vec::new();
    }
    vec![
        format!("This moved {}; add --follow to bring it back with the screws that set it.", moved.join(", ")),
        String::new(),
    ]
}

/// Which other screws must follow, so that the goals are met.
fn must_follow(specification: &Specification, followed: &Regulated, lengths: Lengths) -> String {
    let asked = |goal: Goal| specification.iter().any(|(other, _)| *other == goal);
    let others = followed.achieved.iter().filter(|achieved| !asked(achieved.goal));
    let each: Vec<String> = others
        .map(|achieved| {
            let goal = achieved.goal;
            let screws: Vec<String> = followed.screws_of(goal).map(|turned| turned_text(turned, lengths)).collect();
            let turned = if screws.is_empty() { "its screw as it is".to_owned() } else { screws.join(", ") };
            format!("{} ({turned}; it stays at {})", goal.name(), shown_value(goal, achieved.target, lengths))
        })
        .collect();
    format!("reachable if another screw follows: {}; add --follow", each.join(", "))
}
