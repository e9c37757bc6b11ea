//! `erard study`.

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::SAMPLE;
use erard::parameter::Quantity;
use erard::player::Input;
use erard::run::Setup;
use erard_workshop::compare::Which;
use erard_workshop::sensitivities::Rest;
use erard_workshop::study::{Axis, Column, GRADING, Grid, MAX_STROKES, MakeStroke, Source, Target, Workers, doubts};

use super::bands::{self, BandOptions, BandRow, Banded};
use super::options::{InstrumentOption, RestBefore, StepOptions, StrokeOptions, check, measured_lines};
use super::out::OutOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::{KeyboardKey, load_instrument_and_text, load_keyboard};
use crate::number::number;
use crate::print_line;
use crate::session::Session;
use crate::study::sensitivities as sensitive;
use crate::study::{SpeedBands, crossed, figure, shown, table_of};
use crate::table::{Table, many, spaced};
use crate::warn;

/// Text below the options.
const AFTER: &str = include_str!("help/study.txt");

/// Plays a stroke on many variants of an instrument: a parameter study.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Study {
    /// What to vary, as a range and a number of values (let_off=-1mm..1mm:41) or as values with commas. Repeat it for
    /// all combinations
    #[arg(long, value_name = "NAME=FROM..TO:COUNT", allow_hyphen_values = true)]
    vary: Vec<String>,
    /// Instead of a study, print which numbers of the instrument matter most: derivatives of hammer speed, let-off,
    /// timing and touch weight, the largest first
    #[arg(long, conflicts_with_all = ["vary", "measure", "single"])]
    sensitivities: bool,
    /// With --sensitivities: the parameters, by names and paths as in --vary, with commas [default: every screw and
    /// parameter]
    #[arg(
        long,
        value_name = "NAME,NAME,..",
        value_delimiter = ',',
        requires = "sensitivities",
        conflicts_with = "vary"
    )]
    parameters: Vec<String>,
    /// With --sensitivities: the results, with commas, out of hammer_speed_m_per_s, let_off_s, hammer_contact_s,
    /// key_bottom_s, key_bottom_after_impact_s, free_flight_s, key_start_s, toe_contact_s, key_start_to_hammer_s,
    /// down_weight_g, up_weight_g, balance_weight_g [default: hammer_speed_m_per_s, let_off_s,
    /// key_bottom_after_impact_s, down_weight_g, balance_weight_g]
    #[arg(long, value_name = "KEY,KEY,..", value_delimiter = ',', requires = "sensitivities", conflicts_with = "vary")]
    outcomes: Vec<String>,
    /// With --sensitivities: what happens to the rest at which the stroke starts while a number changes
    #[arg(long, value_enum, default_value = "moves", requires = "sensitivities")]
    rest: RestAsked,
    /// Also measure every variant: keys of measure.json with commas
    /// (down_weight_g,effective_inertia_kg,repetition_rate_half_hz)
    #[arg(long, value_name = "KEY,KEY,..", value_delimiter = ',')]
    measure: Vec<String>,
    /// With --measure: how each variant comes to rest before it is measured. Strokes start as drawn
    #[arg(long, value_name = "REST", value_enum, default_value = "as-played", requires = "measure")]
    measured_rest: RestBefore,
    /// Rows of the printed table, evenly spaced from the first to the last; `all` prints every row [default: 12, or 7
    /// of more; with --full all]
    #[arg(long, value_name = "N|all", value_parser = rows_shown)]
    rows: Option<usize>,
    #[command(flatten)]
    stroke: StrokeOptions,
    #[command(flatten)]
    instrument: InstrumentOption,
    #[command(flatten)]
    step: StepOptions,
    /// Adaptive steps: the largest error of a step, relative to 1 rad/s + |velocity|, from 1e-9 to 0.1; strokes are
    /// then played one by one on all cores [default: fixed steps of --dt]
    #[arg(
        long,
        value_name = "ERROR",
        value_parser = number(Quantity::Number, ""),
        allow_hyphen_values = true,
        conflicts_with_all = ["sensitivities", "single"]
    )]
    tolerance: Option<f64>,
    /// Simulated time of every stroke, s [default: the stroke's duration and a little more]
    #[arg(long, value_name = "S", value_parser = number(Quantity::Time, "s"), allow_hyphen_values = true)]
    duration: Option<f64>,
    #[command(flatten)]
    bands: BandOptions,
    /// Find the hand that reaches the level for each variant. Otherwise all are played by the hand found for the
    /// unvaried instrument. Each key always has its own hand
    #[arg(long, conflicts_with = "sensitivities")]
    hand_per_variant: bool,
    /// Compute in single precision: twice as many strokes at a time, hammer speeds to about 1e-4
    #[arg(long)]
    single: bool,
    #[command(flatten)]
    out: OutOptions,
}

/// What happens to the rest while a number changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RestAsked {
    /// Every variant comes to rest anew, from the pose as drawn, as in `erard press`
    Moves,
    /// Friction holds the pose of the unchanged action
    Held,
}

/// Rows of the printed table: a number, or all.
fn rows_shown(text: &str) -> Result<usize, String> {
    let number = if text == "all" { Some(usize::MAX) } else { text.parse().ok().filter(|rows| *rows > 0) };
    number.ok_or_else(|| "expected a number of rows, from 1, or `all`".to_owned())
}

impl Study {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if self.sensitivities {
            return self.tell_what_matters(session);
        }
        if self.vary.is_empty() {
            return Err(Failure::Usage(
                "nothing to vary; expected --vary, e.g. --vary let_off=-1mm..1mm:41, or --sensitivities for the numbers \
                 that matter most"
                    .into(),
            ));
        }
        self.bands.check(self.instrument.asked())?;
        let measures = measured_lines("--measure", &self.measure)?;
        let (instrument, source) = self.source(session)?;
        let settings = self.step.settings(&instrument)?;
        let axes = Axis::parse_all(&self.vary, &instrument, &source).map_err(Failure::Usage)?;
        let forces = axes.iter().any(|axis| axis.target == Target::Force);
        let stroke =
            if forces { self.stroke.load_constant()? } else { self.stroke.load(session, &self.reference(&source)?)? };
        // Once, so that its errors are reported before any work.
        drop(stroke.inputs(&instrument.finger)?);
        let each = self.each(&axes)?;
        let duration_s = self.duration.unwrap_or(stroke.duration_s);
        let (tolerance, start_s) = (self.tolerance, stroke.start_s);
        let setup = Setup { settings, start_s, tolerance, hand: stroke.hand(), ..Setup::new(duration_s) };
        check(&setup)?;
        let mut output = self.out.prepare(session, "study", &["study.csv"])?;
        let workers = if self.single { Workers::all_single() } else { Workers::all() };
        let make = each.map(|touch| {
            move |instrument: &Instrument, progress: &mut erard::Progress<'_>| touch.touch_on(instrument, progress)
        });
        let grid = Grid {
            instrument: &instrument,
            source: &source,
            model: self.instrument.model,
            axes: &axes,
            lines: &measures,
            rest: self.measured_rest.into(),
            stroke: &stroke,
            each: make.as_ref().map(|make| make as &MakeStroke<'_>),
            setup: &setup,
            workers,
        };
        let mut progress = session.progress("playing");
        let rows = grid.play(&mut |share| progress.tell(share))?;
        drop(progress);
        if rows.iter().all(|row| row.outcome.is_err())
            && let Some(Err(first)) = rows.first().map(|row| &row.outcome)
        {
            let strokes = if rows.len() == 1 { "the stroke".to_owned() } else { format!("all {} strokes", rows.len()) };
            return Err(Failure::Usage(format!("{strokes} failed, and nothing is written; the first: {first}")));
        }

        let columns = grid.columns(&rows);
        let mut table = table_of(&columns, &rows);
        let mut banded = None;
        if let Some(count) = self.bands.bands {
            let found = self.banded(session, &grid, &columns, count)?;
            table = band_columns(table, grid.results(&columns), &found.rows);
            found.stage_failed(session, &mut output)?;
            banded = Some((found, count));
        }
        output.table(session, "study.csv", &table)?;
        let title = format!("{} - {} ({})", instrument.name, stroke.title, stroke.driven());
        let bands = banded.as_ref().map(|(found, samples)| {
            let speeds = found.rows.iter().filter(|row| row.name.ends_with(SPEED));
            SpeedBands { ends: speeds.map(|row| [row.low, row.high]).collect(), samples: *samples }
        });
        if let Some(picture) = figure(&title, &axes, &rows, bands.as_ref()) {
            output.figure(session, "study", &picture)?;
        }
        let written = output.commit(session)?;

        print_line!(session, "{title}");
        let failed = rows.iter().filter(|row| row.outcome.is_err()).count();
        // A row that is not printed may be the one that matters.
        let impacts = |which: fn(usize) -> bool| {
            let played = rows.iter().filter_map(|row| row.outcome.as_ref().ok());
            played.filter(|played| which(played.events.impacts.len())).count()
        };
        let counted =
            [(impacts(|count| count == 0), "without an impact"), (impacts(|count| count > 1), "with several impacts")];
        let counted = counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("; {count} {what}"));
        print_line!(session, "{}; {failed} failed{}", many(rows.len(), "stroke"), counted.collect::<String>());
        let table_lines = |most: usize| {
            let text = shown(&axes, &measures, &rows, most).to_string();
            let mut lines: Vec<String> = text.trim_end_matches('\n').lines().map(str::to_owned).collect();
            if rows.len() > most {
                lines.push(format!(
                    "{most} of {} rows; --rows all prints every one, and study.csv holds them",
                    rows.len()
                ));
            }
            lines
        };
        // The whole grid where it fits, else two axes across each other.
        let first = match self.rows {
            None if rows.len() > WHOLE => crossed(&axes, &measures, &rows),
            _ => None,
        };
        let mut first = first
            .unwrap_or_else(|| table_lines(self.rows.unwrap_or(if rows.len() > WHOLE { FIRST_ROWS } else { WHOLE })));
        let is_whole = first.len() > rows.len() && banded.is_none();
        if is_whole {
            print_line!(session);
            first.iter().for_each(|line| print_line!(session, "{line}"));
        } else {
            let bands = if banded.is_some() { ", and the bands of all results" } else { "" };
            let adds = format!("all {} rows with every instant{bands}", rows.len());
            if let Some((found, count)) = &banded {
                let speeds: Vec<&BandRow> = found.rows.iter().filter(|row| row.name.ends_with(SPEED)).collect();
                let some: Vec<BandRow> =
                    spaced(speeds.len(), FIRST_BANDS).iter().map(|at| speeds[*at].clone()).collect();
                first.push(String::new());
                first.extend(bands::lines(&some, *count));
            }
            Answer::begin_with_part(session, &first, &adds);
            table_lines(self.rows.unwrap_or(usize::MAX)).iter().for_each(|line| print_line!(session, "{line}"));
            if let Some((found, count)) = &banded {
                print_line!(session);
                bands::lines(&found.rows, *count).iter().for_each(|line| print_line!(session, "{line}"));
            }
        }
        let doubts = doubts(rows.iter().map(|row| &row.outcome));
        for doubt in &doubts {
            warn!(session, "warning: this result cannot be trusted: {doubt}");
        }
        print_line!(session);
        let answer = Answer::table(session, Some(&table)).with("instrument", &instrument.name)?;
        let mut answer = answer.with("stroke", &stroke.title)?.with("warnings", &doubts)?;
        if let Some((found, _)) = &banded {
            answer = answer.with("failed_samples", &found.failed)?;
        }
        Ok(answer.end(session, &written))
    }

    /// The values of every row, row by row, with their bands over samples of the instrument: the same study of each.
    fn banded(
        &self,
        session: &mut Session,
        grid: &Grid<'_>,
        columns: &[Column],
        count: u32,
    ) -> Result<Banded, Failure> {
        let Source::Text { .. } = grid.source else {
            return Err(Failure::Usage(
                "--bands needs one instrument or one key; remove --vary key and gradings".into(),
            ));
        };
        let strokes = grid.count() * count as usize;
        if strokes > MAX_STROKES {
            return Err(Failure::Usage(format!(
                "{strokes} strokes; expected at most {MAX_STROKES}. Give --vary fewer values or --bands fewer samples"
            )));
        }
        let mut names: Vec<bands::NameAndUnit> = Vec::new();
        for row in 0..grid.count() {
            let at: Vec<String> = columns[..grid.axes.len()]
                .iter()
                .map(|(name, values)| format!("{name} {}", values[row].unwrap_or(f64::NAN)))
                .collect();
            let results = grid.results(columns).iter();
            names.extend(results.map(|(name, _)| (format!("{}: {name}", at.join(", ")), String::new())));
        }
        bands::bands(
            session,
            self.instrument.asked(),
            count,
            &names,
            &grid.result_values(columns),
            None,
            |instrument, text, progress| grid.of_sample(instrument, text, progress),
        )
    }

    /// The derivatives of a stroke's outcome.
    fn tell_what_matters(&self, session: &mut Session) -> Result<Answer, Failure> {
        let of = sensitive::wanted(&self.outcomes)?;
        let (whole, text) = load_instrument_and_text(session, self.instrument.asked())?;
        let stroke = self.stroke.load(session, &whole)?;
        let instrument = self.instrument.reduced(whole)?;
        let settings = self.step.settings(&instrument)?;
        let by = sensitive::variables(&instrument, &text, &self.parameters, self.stroke.is_constant())?;
        let duration_s = self.duration.unwrap_or(stroke.duration_s);
        let setup =
            Setup { settings, start_s: stroke.start_s, ledger: false, hand: stroke.hand(), ..Setup::new(duration_s) };
        check(&setup)?;
        let files = ["sensitivities.csv", "sensitivities.json", "sensitivities.svg", "sensitivities.png"];
        let mut output = self.out.prepare(session, "study", &files)?;
        // Once, so that its errors are reported before any work.
        drop(stroke.inputs(&instrument.finger)?);
        let finger = instrument.finger;
        let inputs = || stroke.inputs(&finger).unwrap_or_else(|_| Box::new(|_| Input::Free));
        let rest = if self.rest == RestAsked::Held { Rest::Held } else { Rest::Moves };
        let found = sensitive::find(session, &instrument, by, of, &inputs, &setup, rest)?;
        let title = format!("{} - {} ({})", instrument.name, stroke.title, stroke.driven());
        output.table(session, "sensitivities.csv", &Table::of_records(&sensitive::rows(&found))?)?;
        let report = sensitive::report(&found, &instrument.name, &stroke.title);
        output.json(session, "sensitivities.json", &report)?;
        output.figure(session, "sensitivities", &sensitive::figure(&found, &title))?;
        let written = output.commit(session)?;

        let answer = Answer::of(&report)?;
        print_line!(session, "{title}");
        let first = match self.rows {
            Some(rows) => sensitive::lines(&found, rows),
            None => sensitive::first(&found),
        };
        let adds = "more parameters of each result, their spreads, and how the derivatives agree with differences";
        Answer::begin_with_part(session, &first, adds);
        for line in sensitive::lines(&found, self.rows.unwrap_or(FULL_ROWS)) {
            print_line!(session, "{line}");
        }
        print_line!(session);
        let [switches, unresolved] = found.switches;
        if switches > 0 {
            print_line!(session, "{switches} switches of friction during the stroke, {unresolved} of them unresolved");
        }
        Ok(answer.end(session, &written))
    }

    /// The touch whose hand is found for each variant: where that was asked for, and where keys are varied.
    fn each(&self, axes: &[Axis]) -> Result<Option<&StrokeOptions>, Failure> {
        let is_touch = self.stroke.is_touch() && !axes.iter().any(|axis| axis.target == Target::Force);
        let has_levels = self.instrument.model == Which::Action;
        if self.hand_per_variant && !is_touch {
            return Err(Failure::Usage(
                "--hand-per-variant needs a level to reach; add --stroke or --hammer-speed".into(),
            ));
        }
        if self.hand_per_variant && !has_levels {
            return Err(Failure::Usage(
                "--hand-per-variant needs a hammer, and --model one-dof has none; remove one of them".into(),
            ));
        }
        let wanted = self.hand_per_variant || axes.iter().any(|axis| axis.target == Target::Key);
        Ok(Some(&self.stroke).filter(|_| wanted && is_touch && has_levels))
    }

    /// The unvaried instrument, whole: a level is found on it.
    fn reference(&self, source: &Source) -> Result<Instrument, Failure> {
        match source {
            Source::Keyboard(keyboard, key) => Ok(keyboard.key(key.unwrap_or(keyboard.base_key))?),
            Source::Text { text, .. } => Ok(Instrument::parse(text, &self.instrument.asked().to_string())?),
        }
    }

    /// What is varied: a keyboard where keys are, else an instrument.
    fn source(&self, session: &mut Session) -> Result<(Instrument, Source), Failure> {
        let asked = self.instrument.asked();
        let varies = |is_it: &dyn Fn(&str) -> bool| {
            self.vary.iter().any(|text| text.split('=').next().is_some_and(|name| is_it(name.trim())))
        };
        if varies(&|name| name == "key") {
            if asked.key().is_some() || asked.sample().is_some() {
                return Err(Failure::Usage(format!(
                    "{asked}: names one instrument; --vary key needs its keyboard: --instrument {}",
                    asked.base()
                )));
            }
            let keyboard = load_keyboard(session, asked.base())?;
            let mut instrument = self.instrument.reduced(keyboard.key(keyboard.base_key)?)?;
            instrument.rename(&keyboard.name);
            return Ok((instrument, Source::Keyboard(Box::new(keyboard), None)));
        }
        let gradings = varies(&|name| name.starts_with(GRADING));
        if gradings && asked.sample().is_some() {
            return Err(Failure::Usage(format!(
                "{asked}: is a sample; --vary {GRADING}NAME needs the keyboard itself. Remove `{SAMPLE}N`"
            )));
        }
        if gradings && let Some(KeyboardKey { keyboard, key }) = KeyboardKey::asked(session, asked)? {
            let instrument = self.instrument.reduced(keyboard.key(key)?)?;
            return Ok((instrument, Source::Keyboard(Box::new(keyboard), Some(key))));
        }
        let (instrument, text) = load_instrument_and_text(session, asked)?;
        Ok((self.instrument.reduced(instrument)?, Source::of_text(text)))
    }
}

/// A longer table is printed with `--full` only.
const WHOLE: usize = 12;
/// Rows of a longer one that are printed first, where it is not two axes across each other.
const FIRST_ROWS: usize = 7;
/// Bands of the hammer's speed that are printed first.
const FIRST_BANDS: usize = 5;
/// The result that has them.
const SPEED: &str = "hammer_speed_m_per_s";
/// Rows of each result's sensitivities with `--full`.
const FULL_ROWS: usize = 15;

/// Either end of a band.
type BandEnd = fn(&BandRow) -> Option<f64>;

/// A table with the bands of results as columns.
fn band_columns<'a>(table: Table<'a>, results: &[Column], found: &[BandRow]) -> Table<'a> {
    let of = |index: usize, end: BandEnd| found.iter().skip(index).step_by(results.len()).map(end).collect::<Vec<_>>();
    let ends: [(&str, BandEnd); 2] = [("5", |row| row.low), ("95", |row| row.high)];
    let named = results.iter().enumerate().flat_map(|(index, (name, _))| ends.map(|end| (index, name, end)));
    named.fold(table, |table, (index, name, (end, get))| table.optional(format!("{name}_{end}"), of(index, get)))
}
