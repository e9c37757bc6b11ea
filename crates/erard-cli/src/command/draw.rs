//! `erard draw`.

use clap::Args;
use erard::parameter::Quantity;
use erard::player::{Inside, ReactionRecorder};
use erard::run::Setup;
use erard::run::{Events, Run};
use moreau::Settings;

use super::options::{InstrumentOption, StrokeOptions};
use super::out::OutOptions;
use super::press::play_observed;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::LoadedInstrument;
use crate::print_line;
use crate::session::Session;
use crate::suggest::{near, quoted};
use erard_figures::drawing::{PoseOptions, angles_at, forces_at, pins_at, pose_picture};

/// Draws the action in one pose, as SVG and PNG.
#[derive(Debug, Args)]
pub(crate) struct Draw {
    #[command(flatten)]
    stroke: StrokeOptions,
    #[command(flatten)]
    instrument: InstrumentOption,
    /// Instant to draw: ms after the start of the stroke (0 is rest), or an event: key-start, toe-contact, let-off,
    /// hammer-contact, key-bottom, check
    #[arg(long, value_name = "MILLISECONDS-OR-EVENT", default_value = "0", value_parser = parse_at, allow_hyphen_values = true)]
    at: At,
    /// Label the main parts
    #[arg(long)]
    labels: bool,
    /// Draw contact forces as arrows
    #[arg(long)]
    forces: bool,
    /// Draw the forces of the pins on their parts as arrows
    #[arg(long)]
    reactions: bool,
    #[command(flatten)]
    out: OutOptions,
}

/// Which instant.
#[derive(Debug, Clone, Copy)]
enum At {
    /// ms after the stroke's start.
    Ms(f64),
    /// When this happens.
    Event(Event),
}

/// An event of a key press: its name on the command line and in captions, and when it happened in a run, s.
type Event = (&'static str, fn(&Events) -> Option<f64>);

const EVENTS: [Event; 6] = [
    ("key-start", |events| events.key_start_s),
    ("toe-contact", |events| events.toe_contact_s),
    ("let-off", |events| events.let_off_s),
    ("hammer-contact", Events::hammer_contact_s),
    ("key-bottom", |events| events.key_bottom_s),
    ("check", |events| events.check_s),
];

fn parse_at(text: &str) -> Result<At, String> {
    if let Ok(ms) = Quantity::Time.read_in(text, "ms") {
        return if (0.0..=LATEST_MS).contains(&ms) {
            Ok(At::Ms(ms))
        } else {
            Err(format!("expected 0 to {LATEST_MS} ms"))
        };
    }
    EVENTS.into_iter().find(|(name, _)| *name == text).map(At::Event).ok_or_else(|| {
        let names = EVENTS.map(|(name, _)| name);
        let near = near(text, names);
        let meant = if near.is_empty() { String::new() } else { format!("; did you mean {}?", quoted(&near)) };
        format!("expected a number of milliseconds, or one of {}{meant}", names.join(", "))
    })
}

/// Farthest instant that is drawn, ms.
const LATEST_MS: f64 = 600_000.0;

impl Draw {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let LoadedInstrument { instrument, changed, whole } = self.instrument.load_with_notes(session)?;
        let stroke = self.stroke.load(session, &whole)?;
        let settings = Settings::new(instrument.usual_step_s());
        let duration_s = match self.at {
            At::Ms(ms) => (ms * 1e-3).max(settings.step),
            At::Event(_) => stroke.duration_s,
        };
        let setup = Setup { settings, start_s: stroke.start_s, hand: stroke.hand(), ..Setup::new(duration_s) };
        let mut output = self.out.prepare(session, "draw", &["action.svg", "action.png"])?;
        let reactions = self.reactions.then(|| ReactionRecorder::new(&instrument));
        let mut inside = Inside { reactions, losses: None };
        let run = play_observed(session, &instrument, &stroke, &setup, &mut inside)?;
        let row = self.row(&run)?;
        let mut arrows = if self.forces { forces_at(&instrument, &run, row) } else { Vec::new() };
        if let Some(recorder) = inside.reactions {
            arrows.extend(pins_at(&instrument, &run, &recorder.into_series(), row));
        }
        let caption = if row == 0 {
            format!("{}, at rest", run.instrument)
        } else {
            let ms = (run.time_s[row] - stroke.start_s) * 1e3;
            let event = match self.at {
                At::Ms(_) => String::new(),
                At::Event((event, _)) => format!(", {}", event.replace('-', " ")),
            };
            format!("{}, {}, {ms:.1} ms{event}", run.instrument, stroke.title)
        };
        let options = PoseOptions {
            labels: self.labels,
            arrows,
            changed,
            caption: Some(caption.clone()),
            ..PoseOptions::default()
        };
        let picture = pose_picture(&instrument, &angles_at(&run, row), &options);
        output.picture(session, "action", &picture, 1.0)?;
        let written = output.commit(session)?;
        print_line!(session, "{caption}");
        Ok(Answer::table(session, None).end(session, &written))
    }

    /// The row of a run to draw.
    fn row(&self, run: &Run) -> Result<usize, Failure> {
        match self.at {
            At::Ms(ms) => Ok(if ms > 0.0 { run.time_s.len() - 1 } else { 0 }),
            At::Event((name, time_s)) => {
                let time_s = time_s(&run.events).ok_or_else(|| {
                    Failure::Usage(format!(
                        "--at {name}: this stroke has no {}. Name another event or a time in ms",
                        name.replace('-', " ")
                    ))
                })?;
                // The first row that is not before it.
                Ok(run.time_s.partition_point(|&t| t < time_s).min(run.time_s.len() - 1))
            }
        }
    }
}
