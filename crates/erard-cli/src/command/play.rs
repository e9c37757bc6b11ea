//! `erard play`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::Base;
use erard::keyboard::Keyboard;
use erard::parameter::Quantity;
use erard::run::Heard;
use erard_figures::page::{Shown, page_html};
use erard_midi::{Law, file};
use erard_piece::{Options, PerformError, Performance, Score, passage, perform};
use erard_workshop::cores;

use super::out::OutOptions;
use super::press::wav_name;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::load_keyboard;
use crate::law_points::{LawPoints, law_points};
use crate::number::{between, whole};
use crate::output::Output;
use crate::play::spool::Spools;
use crate::play::{Played, Side, page, report};
use crate::print_line;
use crate::session::Session;
use crate::table::many;
use crate::warn;
use crate::wav::{Gain, KnockList};

/// What stands below the options.
const AFTER: &str = include_str!("help/play.txt");
/// Header of a law of one's own.
pub(super) const LAW_HEAD: &str = "m_per_s,velocity";
/// No longer files are read, bytes.
pub(super) const MAX_BYTES: u64 = 16 << 20;

/// Plays a MIDI file on the simulated keys of a keyboard, and says which notes are lost and why.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Play {
    /// The piece: a Standard MIDI File
    #[arg(value_name = "PIECE.mid")]
    piece: PathBuf,
    /// Keyboard: a TOML file, or the name of a built-in one
    #[arg(long, value_name = "KEYBOARD", default_value = "concert-grand-strings")]
    keyboard: Base,
    /// Second keyboard to compare with: which notes are lost on one of the two only
    #[arg(long, value_name = "KEYBOARD")]
    against_keyboard: Option<Base>,
    /// Law between velocity and hammer speed: `logarithmic`, MIDI = 52 + 25 log2(v), v in m/s; `linear:V`, velocity 127
    /// at V m/s; or your own table, a file of points with the head `m_per_s,velocity`
    #[arg(long, value_name = "LAW", default_value = "logarithmic")]
    law: String,
    /// Play only notes that begin at or after this time, s
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = seconds, allow_hyphen_values = true)]
    from: f64,
    /// Play only notes that begin before this time, s [default: all]
    #[arg(long, value_name = "S", value_parser = seconds, allow_hyphen_values = true)]
    to: Option<f64>,
    /// Time from one row of an action to the next while it is awake, ms, 0.05 to 1000
    #[arg(long, value_name = "MS", default_value_t = 1.0, value_parser = between(Quantity::Time, "ms", 0.05, 1000.0), allow_hyphen_values = true)]
    record_interval: f64,
    /// Also write the sound pressure at two places 1 m before the soundboard, NAME.wav in the output folder; without a
    /// board that moves, the force on the bridge. Needs modal strings. Stereo, 48 kHz, 16 bit; full scale is 10 Pa (150
    /// N) for all notes. Without a room; knocks are an estimate. Steps are then 1/48000 s [default: play.wav]
    #[arg(long, value_name = "NAME.wav", num_args = 0..=1, default_missing_value = "play.wav", value_parser = wav_name)]
    wav: Option<String>,
    /// With --wav: scale the sound so that its peak is at 0.9 of full scale
    #[arg(long, requires = "wav")]
    wav_peak: bool,
    /// With --wav, before a soundboard: the knocks that are heard, of key-bed, action-rails, damper-rail; or none
    #[arg(long, value_name = "KNOCKS", requires = "wav", default_value = "all")]
    knocks: KnockList,
    /// Number of notes to show in slow motion, faulty ones first
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = whole::<u16>(0, 500), allow_negative_numbers = true)]
    slow_motion: u16,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1, 256), allow_negative_numbers = true)]
    threads: Option<u16>,
    #[command(flatten)]
    out: OutOptions,
}

/// An instant of a piece, s.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    between(Quantity::Time, "s", 0.0, 1e6)(text)
}

impl Play {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let points = self.law_points(session)?;
        let score = score(session, &self.piece, self.law(&points)?, self.from, self.to)?;
        let names = std::iter::once(&self.keyboard).chain(&self.against_keyboard);
        let keyboards = names.map(|name| load_keyboard(session, name)).collect::<Result<Vec<Keyboard>, Failure>>()?;
        let threads = self.threads.map_or_else(cores::count, usize::from);
        let mut output = self.out.prepare(session, "play", &["summary.json", "play.html"])?;
        let piece = self.piece.file_name().map_or_else(String::new, |name| shown(Path::new(name)));
        let mut played = Played { piece: &piece, score: &score, threads, sides: Vec::new() };
        for (index, keyboard) in keyboards.iter().enumerate() {
            let mark = Side::mark(index, keyboards.len());
            played.sides.push(self.side(session, &score, keyboard, threads, &mark, &mut output)?);
        }
        let summary = report::json(&played);
        output.json(session, "summary.json", &summary)?;
        output.text(session, "play.html", &page::html(&played))?;
        let written = output.commit(session)?;
        self.tell(session, &played);
        for (_, limited) in played.sides.iter().filter_map(|side| side.heard.as_ref()) {
            limited.iter().for_each(|line| warn!(session, "{line}"));
        }
        Ok(Answer::of(&summary)?.end(session, &written))
    }

    /// The points of the law, where they are one's own.
    fn law_points(&self, session: &mut Session) -> Result<Option<LawPoints>, Failure> {
        let is_own = self.law != "logarithmic" && !self.law.starts_with("linear:");
        let file = is_own.then(|| Path::new(&self.law));
        file.map(|path| law_points(session, "--law", path, LAW_HEAD, "logarithmic, linear:V")).transpose()
    }

    fn law<'l>(&self, points: &'l Option<LawPoints>) -> Result<Law<'l>, Failure> {
        if let Some(LawPoints { name, points, .. }) = points {
            return Law::table(points).map_err(|fault| Failure::Usage(format!("{name}: {fault}")));
        }
        let Some(full) = self.law.strip_prefix("linear:") else { return Ok(Law::GOEBL) };
        let found = Quantity::Speed.read_in(full, "m/s").ok().filter(|v| (0.5..=50.0).contains(v));
        found.map(|full_m_per_s| Law::Linear { full_m_per_s }).ok_or_else(|| {
            Failure::Usage(format!(
                "--law: `{}`; expected the speed of velocity 127, linear:0.5 to linear:50",
                self.law
            ))
        })
    }

    /// The piece on one keyboard, and its files.
    fn side(
        &self,
        session: &Session,
        score: &Score<'_>,
        keyboard: &Keyboard,
        threads: usize,
        mark: &str,
        output: &mut Output,
    ) -> Result<Side, Failure> {
        let instruments = keyboard.instruments()?;
        if self.wav.is_some() && !instruments.iter().any(Instrument::has_yielding_strings) {
            let message = "--wav needs modal strings; this keyboard's are rigid. Use --keyboard concert-grand-strings";
            return Err(Failure::Usage(format!("{}: {message}", keyboard.name)));
        }
        let moments = usize::from(self.slow_motion);
        let options = Options {
            row_s: 1e-3 * self.record_interval,
            sound: self.wav.is_some().then(|| Heard::of(&instruments)),
            knocks: self.knocks.0.clone(),
            moments,
            threads,
        };
        let (spools, file) = (Spools::default(), output.spools());
        let mut progress = session.progress(&format!("playing on {}", keyboard.name));
        let started = Instant::now();
        let performed =
            perform(score, &instruments, &options, &|key| spools.sink(key, &file), &mut |share| progress.tell(share));
        let elapsed_s = started.elapsed().as_secs_f64();
        drop(progress);
        let performance = performed.map_err(|error| failed(&keyboard.name, error))?;
        let (rows, sound) = spools.rows_and_sound();
        let made_by = session.provenance.made_by();
        output.stage(session, &format!("actions{mark}.parquet"), |w| rows.write(&made_by, w))?;
        let mut heard = None;
        if let Some(name) = &self.wav {
            let gain = Gain::new(options.sound.unwrap_or_default(), self.wav_peak);
            let mixed =
                file().and_then(|file| sound.mix(file, gain)).map_err(|e| Failure::write(self.out.folder(), e))?;
            let name = format!("{}{mark}.wav", &name[..name.len() - ".wav".len()]);
            let beyond = mixed.limited;
            output.stage(session, &name, |w| mixed.write_wav(gain, file()?, w))?;
            let limited = gain.limited(&name, beyond);
            heard = Some((name, limited));
        }
        let pages = self.slow_motions(session, &instruments, &performance, mark, output)?;
        let side = Side { name: keyboard.name.clone(), performance, elapsed_s, pages, heard };
        output.table(session, &format!("notes{mark}.csv"), &report::table(&side))?;
        Ok(side)
    }

    /// A page for each of some notes, those that went wrong first.
    fn slow_motions(
        &self,
        session: &Session,
        instruments: &[Instrument],
        performance: &Performance,
        mark: &str,
        output: &mut Output,
    ) -> Result<Vec<(usize, String)>, Failure> {
        let is_wrong = |note: usize| !performance.notes[note].faults().is_empty();
        let mut moments: Vec<_> = performance.moments.iter().collect();
        moments.sort_by_key(|moment| (!is_wrong(moment.note), moment.note));
        moments.truncate(usize::from(self.slow_motion));
        moments.sort_by_key(|moment| moment.note);
        let mut progress = session.progress("slow motion");
        let mut pages = Vec::new();
        for (index, moment) in moments.iter().enumerate() {
            let share = index as f64 / moments.len() as f64;
            let instrument = &instruments[moment.key - 1];
            let run = moment.run(instrument, performance.step_s, &mut |_| progress.tell(share))?;
            let played = &performance.notes[moment.note];
            let (title, lines) = (page::heading(moment.note, played), page::note_lines(played, &run));
            let name = format!("note-{:04}{mark}.html", moment.note + 1);
            output.text(session, &name, &page_html(&Shown::new(instrument, &run), &title, &lines))?;
            pages.push((moment.note, name));
        }
        Ok(pages)
    }

    fn tell(&self, session: &mut Session, played: &Played<'_>) {
        let score = played.score;
        print_line!(session, "{} - {}, {:.1} s", played.piece, many(score.notes.len(), "note"), score.duration_s);
        if score.shift_s > 0.0 {
            print_line!(
                session,
                "begins {:.2} s later than written, so that the first hand has time to press",
                score.shift_s
            );
        }
        score.remarks.iter().for_each(|remark| print_line!(session, "{remark}"));
        print_line!(session);
        report::headlines(played).into_iter().for_each(|line| print_line!(session, "{line}"));
        session.printer.begin_rest("counts of notes by fault and reason, more notes, the speed of the computation");
        print_line!(session, "{}", report::text(played));
        for side in &played.sides {
            let times = score.duration_s / side.elapsed_s;
            print_line!(
                session,
                "{}: real-time factor {times:.2} ({:.1} s on {} threads)",
                side.name,
                side.elapsed_s,
                played.threads
            );
        }
        if let Some(mb) = peak_memory_mb() {
            print_line!(session, "peak memory {mb:.0} MB");
        }
        print_line!(session);
    }
}

/// The notes of a piece that begin between two instants, s.
pub(super) fn score<'l>(
    session: &mut Session,
    path: &Path,
    law: Law<'l>,
    from: f64,
    to: Option<f64>,
) -> Result<Score<'l>, Failure> {
    let name = shown(path);
    let wrong = |what: String| Failure::Usage(format!("{name}: {what}"));
    let bytes =
        session.inputs.beginning(path, MAX_BYTES + 1).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let mut piece = file::read(&bytes).map_err(|error| wrong(error.to_string()))?;
    session.provenance.used("piece", &name, Some(&name), &bytes);
    let between = if from > 0.0 || to.is_some() {
        piece = passage(&piece, from, to.unwrap_or(f64::INFINITY));
        " there"
    } else {
        ""
    };
    let score = Score::of(&piece, &law);
    if score.notes.is_empty() {
        let remarks = score.remarks.join("; ");
        let why = if remarks.is_empty() { String::new() } else { format!(" ({remarks})") };
        let expected = "expected notes from A0 to C8 that end after they begin";
        return Err(wrong(format!("no note for a piano{between}{why}; {expected}")));
    }
    Ok(score)
}

/// The most memory that this process has held, MB; `None` where the system does not say.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = peak.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1.024e-3 * kib)
}

/// What is wrong with a performance on a keyboard.
pub(super) fn failed(keyboard: &str, error: PerformError) -> Failure {
    match error {
        PerformError::Work(error) => error.into(),
        PerformError::Sink(source) => Failure::write(Path::new("rows and sound"), source),
        PerformError::Action { .. } | PerformError::Damper(_) | PerformError::NotFinite { .. } => {
            Failure::Usage(format!("{keyboard}: {error}"))
        }
        other => Failure::Internal(format!("{keyboard}: {other}")),
    }
}
