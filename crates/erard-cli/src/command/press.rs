//! `erard press`.

use clap::Args;
use erard::instrument::Instrument;
use erard::knocks::Knock;
use erard::level::LevelError;
use erard::parameter::Quantity;
use erard::player::{Inside, LossRecorder, Observer, ReactionRecorder};
use erard::run::Run;
use erard::run::{Heard, RATE_HZ, Sound, sound};
use erard::run::{Setup, simulate_observed};
use erard::strings::Pedal;
use erard::stroke::Columns;

use super::bands::{self, BandOptions, Banded};
use super::hand::described;
use super::options::{InstrumentsOption, StepOptions, Stroke, StrokeOptions, check};
use super::out::OutOptions;
use super::press_pair::{self, Played};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inside::{self, LossReport, losses_picture, reactions_picture};
use crate::instruments::LoadedInstrument;
use crate::number::number;
use crate::print_line;
use crate::session::Session;
use crate::spectrogram::spectrogram_picture;
use crate::summary::{MEASURES, Measure, Summary, headlines, value};
use crate::table::Table;
use crate::warn;
use crate::wav::{Gain, KnockList};
use erard_figures::drawing::moving_svg;
use erard_figures::figure::run_picture;
use erard_figures::page::{Shown, page_html};
use erard_workshop::compare::{ForceUncertainty, PathNoise};
use erard_workshop::sample::{SampleError, unless_interrupted};
use serde_json::json;

/// Simulates one key press and shows what happened.
#[derive(Debug, Args)]
pub(crate) struct Press {
    #[command(flatten)]
    stroke: StrokeOptions,
    /// Second stroke, shown with the first: pp, p, mf, f, ff, a constant force such as 3N, or a file
    #[arg(long, value_name = "STROKE")]
    against: Option<String>,
    /// Columns of the second stroke's file, written as in --columns [default: those of --columns]
    #[arg(long, value_name = "NAME=TITLE,..", requires = "against")]
    against_columns: Option<Columns>,
    #[command(flatten)]
    instrument: InstrumentsOption,
    #[command(flatten)]
    step: StepOptions,
    /// Simulated time, s [default: the stroke's duration and a little more]
    #[arg(long, value_name = "S", value_parser = number(Quantity::Time, "s"), allow_hyphen_values = true)]
    duration: Option<f64>,
    /// Steps from one row of the output to the next [default: 1, in long runs more]
    #[arg(long, value_name = "STEPS", value_parser = steps, allow_negative_numbers = true)]
    record_every: Option<u64>,
    /// Adaptive steps: the largest error of a step, relative to 1 rad/s + |velocity|, from 1e-9 to 0.1 [default: fixed
    /// steps of --dt]
    #[arg(long, value_name = "ERROR", value_parser = number(Quantity::Number, ""), allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Also record the forces in the pins (both components) and the accelerations of the parts: more columns,
    /// reactions.svg and reactions.png
    #[arg(long)]
    reactions: bool,
    /// Show the energy lost at each pin and contact: losses.json, losses.svg and losses.png
    #[arg(long)]
    losses: bool,
    /// Also write the note as a picture that moves, slowed, in any browser: moving.svg
    #[arg(long)]
    moving: bool,
    /// Write the sound pressure at two places 1 m before the soundboard, NAME.wav in the output folder, and the
    /// spectrogram of the left one (SVG and PNG); without a board that moves, the force on the bridge. Needs modal
    /// strings. Stereo, 48 kHz, 16 bit; full scale is 10 Pa (150 N) for all notes. Without a room; knocks are an
    /// estimate. The note is simulated again for it in steps of 1/96000 s [default: note.wav]
    #[arg(long, value_name = "NAME.wav", num_args = 0..=1, default_missing_value = "note.wav", value_parser = wav_name)]
    wav: Option<String>,
    /// With --wav: scale the sound so that its peak is at 0.9 of full scale
    #[arg(long, requires = "wav")]
    wav_peak: bool,
    /// With --wav, before a soundboard: the knocks that are heard, of key-bed, action-rails, damper-rail; or none
    #[arg(long, value_name = "KNOCKS", requires = "wav", default_value = "all")]
    knocks: KnockList,
    /// Sustain pedal, as the lift of its rail: held (7mm), or moved in straight lines between instants of the stroke
    /// (0s=0mm,0.2s=7mm,1s=0mm); without a unit mm and s. For instruments with modal strings [default: up]
    #[arg(long, value_name = "LIFT", allow_hyphen_values = true, default_value = "0mm", hide_default_value = true)]
    pedal: Pedal,
    /// Find the hand that reaches the level for each instrument and each sample of --bands. Otherwise all are played by
    /// the hand found for the first
    #[arg(long)]
    hand_per_variant: bool,
    #[command(flatten)]
    bands: BandOptions,
    #[command(flatten)]
    out: OutOptions,
}

/// A number of steps.
fn steps(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|steps| *steps > 0).ok_or_else(|| "expected a whole number of steps, from 1".to_owned())
}

/// What a sound file holds.
pub(super) fn heard_as(heard: Heard) -> &'static str {
    match heard {
        Heard::Pressure => "the sound pressure 1 m before the board, without a room",
        _ => "the force on the bridge, without a soundboard",
    }
}

/// A name of a file in the output folder that says what it is.
pub(super) fn wav_name(text: &str) -> Result<String, String> {
    let is_sound = text.len() > 4 && text.to_ascii_lowercase().ends_with(".wav");
    if !is_sound || text.contains(['/', '\\', ':']) {
        return Err(format!(
            "found `{text}`; expected a file name that ends in .wav, without a folder (--out names the folder; write a stroke file before --wav)"
        ));
    }
    Ok(text.to_owned())
}

impl Press {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let against = self.against.as_ref().map(|other| self.stroke.with(other, self.against_columns.as_ref()));
        self.instrument.first().map_or(Ok(()), |first| self.bands.check(first))?;
        let instruments = self.instrument.load(session)?;
        let reference = instruments.first().map(|one| &one.whole);
        let Some(reference) = reference else { return Err(Failure::Internal("no instrument".into())) };
        let settings = self.step.settings(reference)?;
        let own = against.as_ref().map_or_else(|| self.stroke.clone(), |other| self.stroke.beside(other));
        let (stroke, noise) = own.load_with_noise(session, reference)?;
        let setup = |stroke: &Stroke| Setup {
            settings,
            start_s: stroke.start_s,
            record_every: self.record_every,
            tolerance: self.tolerance,
            pedal: self.pedal,
            hand: stroke.hand(),
            ..Setup::new(self.duration.unwrap_or(stroke.duration_s))
        };
        if self.against.is_some() || instruments.len() == 2 {
            let strokes = self.strokes(session, &instruments, (stroke, noise), against.as_ref(), reference)?;
            return self.pair(session, &instruments, strokes, setup);
        }
        let [LoadedInstrument { instrument, changed, .. }] = &instruments[..] else {
            return Err(Failure::Internal("no instrument".into()));
        };
        let setup = setup(&stroke);
        check(&setup)?;
        if self.wav.is_some() && !instrument.has_yielding_strings() {
            let message =
                "--wav needs modal strings; this instrument's string is rigid. Use --instrument concert-grand-strings";
            return Err(Failure::Usage(message.into()));
        }
        let mut output =
            self.out.prepare(session, "press", &["run.csv", "summary.json", "run.svg", "run.png", "run.html"])?;
        let mut inside = Inside {
            reactions: self.reactions.then(|| ReactionRecorder::new(instrument)),
            losses: self.losses.then(|| LossRecorder::new(instrument)),
        };
        let run = play_observed(session, instrument, &stroke, &setup, &mut inside)?;
        let driven = stroke.driven();
        let names = [self.instrument.model.name(), stroke.drive_name(), self.step.solver_name()];
        let mut summary = Summary::new(&run, &setup, names);
        add_force_uncertainty(session, &mut summary, &run, instrument, &stroke, &setup, noise.as_ref())?;

        let picture = run_picture(&run, &stroke.title);
        let pins = inside.reactions.map(ReactionRecorder::into_series).unwrap_or_default();
        let shown_run = Shown { pins: &pins, changed, sound: self.wav.as_deref(), ..Shown::new(instrument, &run) };
        let page = page_html(&shown_run, &stroke.title, &summary.lines());
        let table = Table::of_run(&run, inside::columns(&pins));
        output.table(session, "run.csv", &table)?;
        output.json(session, "summary.json", &summary.json)?;
        output.figure(session, "run", &picture)?;
        output.text(session, "run.html", &page)?;
        let title = format!("{} - {}", run.instrument, stroke.title);
        if self.moving {
            output.text(session, "moving.svg", &moving_svg(instrument, &run, &title))?;
        }
        if self.reactions {
            output.figure(session, "reactions", &reactions_picture(&run, &title, &pins))?;
        }
        let sound = match &self.wav {
            Some(name) => listen(session, instrument, &stroke, &setup, &self.knocks.0)?
                .map(|sound| (name, Gain::new(sound.heard, self.wav_peak), sound)),
            None => None,
        };
        if let Some((name, gain, sound)) = &sound {
            output.stage(session, name, |w| crate::wav::write(sound, *gain, w))?;
            let left: Vec<f64> = sound.samples.iter().map(|[left, _]| *left).collect();
            let what = heard_as(sound.heard);
            output.figure(session, "spectrogram", &spectrogram_picture(&left, f64::from(RATE_HZ), &title, what))?;
        }
        let mut lost = None;
        if let Some((recorded, losses)) = inside.losses.as_ref().and_then(|one| Some((one, one.losses()?))) {
            let report = LossReport::new(instrument, losses);
            output.json(session, "losses.json", &report)?;
            output.figure(session, "losses", &losses_picture(&run, &title, recorded, &report))?;
            lost = Some(report);
        }
        let banded = match self.bands.bands {
            Some(count) => {
                let banded = self.banded(session, &summary, &stroke, &setup, count)?;
                banded.stage(session, &mut output)?;
                Some((banded, count))
            }
            None => None,
        };
        let written = output.commit(session)?;
        let mut answer = Answer::of(&summary.json)?.with("stroke", &stroke.title)?.with("hand", &described(&stroke))?;
        if let Some((banded, _)) = &banded {
            answer = answer.with("bands", &banded.rows)?.with("failed_samples", &banded.failed)?;
        }
        if let Some(report) = &lost {
            answer = answer.with("losses", report)?;
        }
        if let Some((name, gain, sound)) = &sound {
            let beyond = sound.samples.iter().flatten().filter(|n| gain.limits(**n)).count();
            let (peak, force) = (sound.peak(), sound.heard == Heard::BridgeForce);
            let peaks = [Some(peak).filter(|_| force), Some(peak).filter(|_| !force)];
            let heard = json!({"file": name, "peak_N": peaks[0], "peak_Pa": peaks[1], "limited_samples": beyond});
            answer = answer.with("sound", &heard)?;
            gain.limited(name, beyond as u64).into_iter().for_each(|line| warn!(session, "{line}"));
        }

        print_line!(session, "{} - {} ({driven})", run.instrument, stroke.title);
        let adds = if banded.is_some() { "every instant with its band" } else { "every instant" };
        let adds = format!("{adds}, the hand, the lift from the rail, the energy residual and the steps");
        answer.begin(session, headlines, &adds);
        if let Some(hand) = described(&stroke) {
            print_line!(session, "hand: {hand}");
            print_line!(session);
        }
        print_line!(session, "{summary}");
        if let Some(uncertainty) = &summary.force_uncertainty {
            print_line!(session, "{uncertainty}");
            print_line!(session);
        }
        if let Some((banded, count)) = &banded {
            bands::lines(&banded.rows, *count).iter().for_each(|line| print_line!(session, "{line}"));
            print_line!(session);
        }
        if let Some(report) = &lost {
            print_line!(session, "{}", report.table());
        }
        if let Some((name, _, sound)) = &sound {
            let (what, peak) = (heard_as(sound.heard), format!("{:.3}", sound.peak()));
            print_line!(session, "{name} is {what}, {peak} {} at most; steps of 1/96000 s", sound.heard.unit());
            print_line!(session);
        }
        for warning in &summary.warnings {
            warn!(session, "warning: this run cannot be trusted: {warning}");
        }
        Ok(answer.end(session, &written))
    }

    /// What happened, with its bands over samples of the instrument.
    fn banded(
        &self,
        session: &mut Session,
        own: &Summary,
        stroke: &Stroke,
        setup: &Setup,
        count: u32,
    ) -> Result<Banded, Failure> {
        // The key of the summary, its unit that of the table.
        let name = |&(key, _, factor, unit, _): &Measure| match key.rsplit_once('_') {
            Some((stem, _)) if factor != 1.0 => (format!("{stem}_{unit}"), unit.to_owned()),
            _ => (key.to_owned(), unit.to_owned()),
        };
        let names: Vec<bands::NameAndUnit> = MEASURES.iter().map(name).collect();
        let values = |summary: &Summary| MEASURES.iter().map(|one| value(&summary.json, one)).collect::<Vec<_>>();
        let names_of = [self.instrument.model.name(), stroke.drive_name(), self.step.solver_name()];
        let model = self.instrument.model;
        let each = self.hand_per_variant && self.stroke.is_touch();
        let Some(asked) = self.instrument.first() else { return Err(Failure::Internal("no instrument".into())) };
        bands::bands(session, asked, count, &names, &values(own), None, |instrument, _, progress| {
            let found = each.then(|| self.stroke.touch_on(instrument, progress)).transpose();
            let found = match found {
                Err(LevelError::Interrupted) => return Err(SampleError::Interrupted),
                Err(error) => return Ok(Err(error.to_string()).into()),
                Ok(found) => found,
            };
            let stroke = found.as_ref().unwrap_or(stroke);
            let setup = &Setup { hand: stroke.hand(), ..*setup };
            let instrument = match model.of(instrument.clone()) {
                Ok(instrument) => instrument,
                Err(error) => return Ok(Err(error.to_string()).into()),
            };
            let inputs = match stroke.inputs(&instrument.finger) {
                Ok(inputs) => inputs,
                Err(error) => return Ok(Err(error.to_string()).into()),
            };
            let run = simulate_observed(&instrument, inputs.as_ref(), setup, &mut Inside::default(), progress);
            let run = unless_interrupted(run)?;
            Ok(run.map(|run| values(&Summary::new(&run, setup, names_of))).into())
        })
    }

    /// The strokes of a pair: one for both instruments, or two.
    fn strokes(
        &self,
        session: &mut Session,
        instruments: &[LoadedInstrument],
        stroke: Noisy,
        against: Option<&StrokeOptions>,
        reference: &Instrument,
    ) -> Result<Vec<Noisy>, Failure> {
        match (against, instruments) {
            (Some(_), [_, _]) => Err(Failure::Usage(
                "--against with two instruments: expected either two instruments or two strokes, so that the page shows one difference".into(),
            )),
            (Some(other), _) => Ok(vec![stroke, other.load_with_noise(session, reference)?]),
            (None, [first, second]) if self.stroke.is_touch() && (self.hand_per_variant || are_keys(first, second)) => {
                Ok(vec![stroke, self.stroke.load_with_noise(session, &second.whole)?])
            }
            (None, _) => Ok(vec![stroke]),
        }
    }

    /// Two instruments under one stroke, or one under two.
    fn pair(
        &self,
        session: &mut Session,
        instruments: &[LoadedInstrument],
        strokes: Vec<Noisy>,
        setup: impl Fn(&Stroke) -> Setup,
    ) -> Result<Answer, Failure> {
        if self.bands.bands.is_some() {
            return Err(Failure::Usage(
                "--bands needs a single run; leave out --against and the second --instrument".into(),
            ));
        }
        if self.reactions || self.losses || self.moving || self.wav.is_some() {
            return Err(Failure::Usage(
                "--reactions, --losses, --moving and --wav need a single run; leave out --against and the second --instrument"
                    .into(),
            ));
        }
        let mut setups: Vec<Setup> = strokes.iter().map(|(stroke, _)| setup(stroke)).collect();
        // One clock: both are played as long as the longer one.
        let longest = setups.iter().map(|setup| setup.duration_s).fold(0.0, f64::max);
        setups.iter_mut().for_each(|setup| setup.duration_s = longest);
        setups.iter().try_for_each(check)?;
        let mut output = self.out.prepare(session, "press", &press_pair::FILES)?;
        let mut played = Vec::new();
        for index in 0..2 {
            let at = |count: usize| index.min(count - 1);
            let (LoadedInstrument { instrument, changed, .. }, (stroke, noise), setup) =
                (&instruments[at(instruments.len())], &strokes[at(strokes.len())], &setups[at(setups.len())]);
            let run = play_observed(session, instrument, stroke, setup, &mut Inside::default())?;
            let names = [self.instrument.model.name(), stroke.drive_name(), self.step.solver_name()];
            let mut summary = Summary::new(&run, setup, names);
            add_force_uncertainty(session, &mut summary, &run, instrument, stroke, setup, noise.as_ref())?;
            played.push(Played { instrument, changed, stroke: stroke.title.clone(), run, summary });
        }
        let Ok(played) = <[Played; 2]>::try_from(played) else { return Err(Failure::Internal("not two runs".into())) };
        let summary = press_pair::write(session, &played, &mut output)?;
        let written = output.commit(session)?;
        let answer = Answer::of(&summary)?;
        print_line!(session, "{}", press_pair::title(&played));
        let adds = "every instant and the work of the finger";
        Answer::begin_with_part(session, &press_pair::headlines(&played), adds);
        press_pair::tell(session, &played);
        for (one, name) in played.iter().zip(press_pair::names(&played)) {
            if let Some(uncertainty) = &one.summary.force_uncertainty {
                print_line!(session, "{name}: {uncertainty}");
            }
            for warning in &one.summary.warnings {
                warn!(session, "warning: {name}: this run cannot be trusted: {warning}");
            }
        }
        Ok(answer.end(session, &written))
    }
}

/// Whether two instruments are different keys: each has a touch of its own.
fn are_keys(first: &LoadedInstrument, second: &LoadedInstrument) -> bool {
    first.instrument.key().zip(second.instrument.key()).is_some_and(|(first, second)| first != second)
}

/// A stroke, with the noise of its recorded position and until when it rests, s, where it has both.
type Noisy = (Stroke, Option<(PathNoise, f64)>);

/// Adds what the run's force is worth where a noisy motion drives it.
fn add_force_uncertainty(
    session: &Session,
    summary: &mut Summary,
    run: &Run,
    instrument: &Instrument,
    stroke: &Stroke,
    setup: &Setup,
    noise: Option<&(PathNoise, f64)>,
) -> Result<(), Failure> {
    let Some((noise, rest_until_s)) = noise else { return Ok(()) };
    let mut progress = session.progress("playing the motion with its noise");
    let mut tell = |share: f64| progress.tell(share);
    if let Some(uncertainty) =
        ForceUncertainty::of_run(run, instrument, stroke, setup, (noise, *rest_until_s), &mut tell)?
    {
        summary.set_force_uncertainty(&uncertainty, stroke.drive);
    }
    Ok(())
}

/// A stroke played once more, to be heard.
fn listen(
    session: &Session,
    instrument: &Instrument,
    stroke: &Stroke,
    setup: &Setup,
    knocks: &[Knock],
) -> Result<Option<Sound>, Failure> {
    let mut progress = session.progress("listening");
    let inputs = stroke.inputs(&instrument.finger)?;
    Ok(sound(instrument, inputs.as_ref(), setup, knocks, &mut |share| progress.tell(share))?)
}

/// A stroke simulated before an observer.
pub(crate) fn play_observed(
    session: &Session,
    instrument: &Instrument,
    stroke: &Stroke,
    setup: &Setup,
    observer: &mut dyn Observer,
) -> Result<Run, Failure> {
    let mut progress = session.progress("simulating");
    let mut tell = |share: f64| {
        progress.say(if share > 0.0 { "simulating" } else { "coming to rest" });
        progress.tell(share)
    };
    let inputs = stroke.inputs(&instrument.finger)?;
    Ok(simulate_observed(instrument, inputs.as_ref(), setup, observer, &mut tell)?)
}
