//! `erard scan`.

use erard::parameter::Quantity;
use std::path::PathBuf;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::InstrumentSpec;
use erard::key::{UnknownKey, keys_named};
use erard::keyboard::{KEYS, Keyboard};
use erard::run::SimulationError;
use erard_live::contact_table::{ContactTableError, PRESSED_KEY, Presses};
use erard_live::contacts::ContactLaw;
use erard_midi::Law;
use erard_piece::scan::{Case, MAX_RATE_HZ, Scans, Sensor, Shank, Truth, play_cases};
use erard_piece::{Options, Score, perform};
use erard_workshop::cores;
use erard_workshop::measure::MeasureError;
use erard_workshop::sample::technicians_scatter;

use super::out::OutOptions;
use super::play::{failed, score, seconds};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::{keyboard_sample, load_keyboard};
use crate::number::{Values, between, list, whole};
use crate::print_line;
use crate::scan::{Scanned, report};
use crate::session::Session;
use crate::suggest::meant;

/// What stands below the options.
const AFTER: &str = include_str!("help/scan.txt");
/// More sensors are not read at once.
const MAX_SENSORS: usize = 100;
/// Changes of a contact within this time after an edge are bounces, s.
const BOUNCE_S: f64 = 2e-3;
/// Cases begin so long after the piece, and after the beginning, s.
const PAUSE_S: f64 = 0.5;

/// Writes what sensors under the keys read while a piece or misleading motions are played, and the true strikes beside
/// it.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Scan {
    /// Piece that is played: a Standard MIDI File
    #[arg(value_name = "PIECE.mid", required_unless_present = "cases")]
    piece: Option<PathBuf>,
    /// Play motions that mislead simple algorithms, after the piece: all of them, or those named
    #[arg(long, value_name = "NAME,NAME,..", num_args = 0..=1, default_missing_value = "all", value_parser = cases)]
    cases: Option<Cases>,
    /// Keys on which the cases are played, by number or note
    #[arg(long, value_name = "KEY,KEY,..", default_value = "16,40,52,64", value_parser = keys)]
    keys: Keys,
    /// Keyboard: a TOML file, or the name of a built-in one. `:sample=17` at the end takes a random grand within the
    /// spreads of its file
    #[arg(long, value_name = "KEYBOARD", default_value = "concert-grand:sample=1")]
    keyboard: InstrumentSpec,
    /// The sensors read the hammers' shanks instead of the keys
    #[arg(long)]
    hammers: bool,
    /// Two or three contacts under each key instead of sensors: depths of the key's front at which they close, mm, the
    /// upper one first. Their edges are written
    #[arg(long, value_name = "MM,MM", value_parser = list(between(Quantity::Length, "mm", 0.1, 20.0)), conflicts_with_all = ["hammers", "bits"], allow_hyphen_values = true)]
    contacts: Option<Values>,
    /// Do not add the differences between keys that a technician leaves
    #[arg(long)]
    no_scatter: bool,
    /// Bits of the converters, one or several numbers from 4 to 24. A key's travel takes three quarters of the range
    #[arg(long, value_name = "N,N,..", default_value = "12", value_delimiter = ',', value_parser = whole::<u32>(4, 24), allow_negative_numbers = true)]
    bits: Vec<u32>,
    /// Readings of each key a second, Hz, one or several numbers from 20 to 20000
    #[arg(long, value_name = "HZ,HZ,..", default_value = "1000", value_parser = list(between(Quantity::Frequency, "Hz", 20.0, MAX_RATE_HZ)), allow_hyphen_values = true)]
    rate: Vec<Values>,
    /// Noise of the sensors: standard deviation, % of a key's travel, one or several numbers from 0 to 10
    #[arg(long, value_name = "%,%,..", default_value = "0.05", value_parser = list(between(Quantity::Share, "%", 0.0, 10.0)), allow_hyphen_values = true)]
    noise: Vec<Values>,
    /// Seed of the noise, the scatter and the cases' motions
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(0, 1_000_000), allow_negative_numbers = true)]
    seed: u32,
    /// Play only notes that begin at or after this time, s
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = seconds, allow_hyphen_values = true)]
    from: f64,
    /// Play only notes that begin before this time, s [default: all]
    #[arg(long, value_name = "S", value_parser = seconds, allow_hyphen_values = true)]
    to: Option<f64>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1, 256), allow_negative_numbers = true)]
    threads: Option<u16>,
    #[command(flatten)]
    out: OutOptions,
}

/// The cases that are asked for, in their own order.
#[derive(Debug, Clone)]
struct Cases(Vec<Case>);

fn cases(text: &str) -> Result<Cases, String> {
    let known = || Case::ALL.map(Case::name).join(", ");
    let named = |name: &str| Case::ALL.into_iter().find(|case| case.name() == name);
    let unknown = text.split(',').find(|name| *name != "all" && named(name).is_none());
    if let Some(name) = unknown {
        let meant = meant(name, Case::ALL.map(Case::name));
        return Err(format!("found `{name}`; expected `all` or names with commas out of {}{meant}", known()));
    }
    let is_asked = |case: &Case| text.split(',').any(|name| name == "all" || name == case.name());
    Ok(Cases(Case::ALL.into_iter().filter(is_asked).collect()))
}

/// Keys, from 1, ascending.
#[derive(Debug, Clone)]
struct Keys(Vec<usize>);

fn keys(text: &str) -> Result<Keys, String> {
    let wrong =
        |UnknownKey { found }| format!("found key `{found}`; expected numbers from 1 to {KEYS} or notes with commas");
    let mut keys = keys_named(text).map_err(wrong)?;
    keys.sort_unstable();
    keys.dedup();
    Ok(Keys(keys))
}

impl Scan {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let score =
            self.piece.as_deref().map(|piece| score(session, piece, Law::GOEBL, self.from, self.to)).transpose()?;
        let sensors = self.sensors()?;
        let (name, sample) = (self.keyboard.base(), self.keyboard.sample());
        if self.keyboard.key().is_some() {
            return Err(Failure::Usage(format!(
                "--keyboard {}: names one key; expected a keyboard: {name}",
                self.keyboard
            )));
        }
        let own = load_keyboard(session, name)?;
        let mut output = self.out.prepare(session, "scan", &["truth.csv", "windows.csv", "scan.json"])?;
        let contacts = self.contact_laws(session, &own, &sensors)?;
        let keyboard = match sample {
            Some(sample) => keyboard_sample(session, &own, &name.to_string(), sample)?,
            None => own,
        };
        let played = self.played(score.as_ref());
        let instruments = self.instruments(session, &keyboard, sample.unwrap_or(0), &played)?;
        let shanks = if self.hammers { shanks(&keyboard.name, &instruments, &played)? } else { Vec::new() };
        let depths_m = self.depths_m();
        let (travels_m, scans) = if self.hammers {
            let travels_m = shanks.iter().map(|shank| shank.map_or(f64::INFINITY, |shank| shank.way_m)).collect();
            (travels_m, Scans::of_hammers(&sensors, shanks, u64::from(self.seed)))
        } else {
            let travels_m = travels_m(&keyboard.name, &instruments, &played)?;
            let scans = Scans::of_contacts(&sensors, travels_m.clone(), &depths_m, u64::from(self.seed));
            (travels_m, scans)
        };
        let truth = self.play(session, score.as_ref(), &keyboard.name, &instruments, &scans)?;
        let asked = self.keyboard.to_string();
        let scanned = Scanned {
            piece: self.piece.as_deref().map(crate::inputs::shown),
            score: score.as_ref(),
            keyboard: &keyboard,
            asked: &asked,
            sample,
            has_scatter: !self.no_scatter,
            seed: self.seed,
            instruments: &instruments,
            travels_m: &travels_m,
            are_hammers: self.hammers,
            contacts: &contacts,
            played: &played,
            sensors: &sensors,
            truth: &truth,
        };
        let counts = scanned.write(session, scans.readings(), &mut output)?;
        let report = report::json(&scanned, &counts);
        output.json(session, "scan.json", &report)?;
        let written = output.commit(session)?;
        print_line!(session, "{}", report::heading(&scanned));
        let answer = Answer::of(&report)?;
        answer.begin(session, |_| report::headlines(&scanned, &counts), "a row for each kind of motion");
        print_line!(session, "{}", report::text(&scanned));
        Ok(answer.end(session, &written))
    }

    /// All sensors that are asked for.
    fn sensors(&self) -> Result<Vec<Sensor>, Failure> {
        let mut sensors: Vec<Sensor> = Vec::new();
        for &bits in if self.contacts.is_some() { &[1][..] } else { &self.bits } {
            for &rate_hz in self.rate.iter().flat_map(|list| &list.0) {
                for &percent in self.noise.iter().flat_map(|list| &list.0) {
                    let sensor = Sensor { bits, rate_hz, noise: 0.01 * percent };
                    if !sensors.contains(&sensor) {
                        sensors.push(sensor);
                    }
                }
            }
        }
        if sensors.len() > MAX_SENSORS {
            let found = sensors.len();
            let what = format!("--bits, --rate and --noise ask for {found} sensors; expected at most {MAX_SENSORS}");
            return Err(Failure::Usage(what));
        }
        Ok(sensors)
    }

    fn depths_m(&self) -> Vec<f64> {
        self.contacts.iter().flat_map(|Values(depths_mm)| depths_mm).map(|mm| 1e-3 * mm).collect()
    }

    /// The contacts as the file's own grand plays them, by the rate of their scan, Hz; none for other sensors.
    fn contact_laws(
        &self,
        session: &Session,
        own: &Keyboard,
        sensors: &[Sensor],
    ) -> Result<Vec<(f64, ContactLaw)>, Failure> {
        if self.contacts.is_none() {
            return Ok(Vec::new());
        }
        let depths_m = self.depths_m();
        let wrong = |what: &dyn std::fmt::Display| Failure::Usage(format!("--contacts: {what}"));
        ContactLaw::check_contacts(&depths_m, &[], 0.0, 0.0).map_err(|fault| wrong(&fault))?;
        let instrument = own.key(PRESSED_KEY)?;
        let mut progress = session.progress("pressing a key");
        let presses = Presses::of(&instrument, &mut |share| progress.tell(share)).map_err(|error| match error {
            ContactTableError::Interrupted => SimulationError::Interrupted.into(),
            error => wrong(&error),
        })?;
        let mut laws: Vec<(f64, ContactLaw)> = Vec::new();
        for Sensor { rate_hz, .. } in sensors {
            if laws.iter().all(|(other_hz, _)| other_hz != rate_hz) {
                // A tenth of a microsecond, as a profile holds it.
                let period_s = 1e-10 * (1e10 / rate_hz).round();
                let law = presses.law(&depths_m, period_s, BOUNCE_S).map_err(|error| wrong(&error))?;
                laws.push((*rate_hz, law));
            }
        }
        Ok(laws)
    }

    /// The keys that are played, ascending.
    fn played(&self, score: Option<&Score<'_>>) -> Vec<usize> {
        let mut keys: Vec<usize> = score.iter().flat_map(|score| &score.notes).map(|note| note.key).collect();
        if self.cases.is_some() {
            keys.extend(&self.keys.0);
        }
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// The instruments of all keys; those that are played differ by what a technician leaves.
    fn instruments(
        &self,
        session: &Session,
        keyboard: &Keyboard,
        sample: u32,
        played: &[usize],
    ) -> Result<Vec<Instrument>, Failure> {
        let mut instruments = keyboard.instruments()?;
        if self.no_scatter {
            return Ok(instruments);
        }
        let wrong = |error| match error {
            error if MeasureError::is_interruption(&error) => erard::run::SimulationError::Interrupted.into(),
            error => Failure::Measure { label: keyboard.name.clone(), error: Box::new(error) },
        };
        // Another seed is another technician.
        let number = sample ^ self.seed << 20;
        let mut progress = session.progress("regulating keys");
        let off = cores::map(played, self.threads(), &mut |share| progress.tell(share), |&key, progress| {
            let mut one = instruments[key - 1].clone();
            technicians_scatter(&mut one, number, key, progress)?;
            Ok::<_, MeasureError>((key, one))
        });
        for (key, one) in off.map_err(wrong)? {
            instruments[key - 1] = one;
        }
        Ok(instruments)
    }

    fn play(
        &self,
        session: &Session,
        score: Option<&Score<'_>>,
        keyboard: &str,
        instruments: &[Instrument],
        scans: &Scans,
    ) -> Result<Truth, Failure> {
        let (mut truth, threads) = (Truth::default(), self.threads());
        if let Some(score) = score {
            let options = Options { row_s: 0.0, threads, ..Options::default() };
            let mut progress = session.progress(&format!("playing on {keyboard}"));
            let tell = &mut |share| progress.tell(share);
            let played = perform(score, instruments, &options, &|key| Ok(scans.sink(key)), tell);
            truth =
                Truth::of_performance(&played.map_err(|error| failed(keyboard, error))?.notes, score.duration_s + 1.0);
        }
        if let Some(Cases(cases)) = &self.cases {
            let mut progress = session.progress("playing cases");
            let (begins_s, tell) = (truth.end_s() + PAUSE_S, &mut |share| progress.tell(share));
            let what = (&self.keys.0[..], &cases[..]);
            let played = play_cases(instruments, what, begins_s, u64::from(self.seed), scans, threads, tell);
            truth.add(played.map_err(|error| failed(keyboard, error))?);
        }
        Ok(truth)
    }

    fn threads(&self) -> usize {
        self.threads.map_or_else(cores::count, usize::from)
    }
}

/// The travel of each key's front, m; infinite of keys that are not played.
fn travels_m(keyboard: &str, instruments: &[Instrument], played: &[usize]) -> Result<Vec<f64>, Failure> {
    let mut travels_m = vec![f64::INFINITY; instruments.len()];
    for &key in played {
        let found = erard_live::dip_m(&instruments[key - 1]);
        travels_m[key - 1] = found.map_err(|error| Failure::Usage(format!("{keyboard}, key {key}: {error}")))?;
    }
    Ok(travels_m)
}

/// The hammers of the keys that are played.
fn shanks(keyboard: &str, instruments: &[Instrument], played: &[usize]) -> Result<Vec<Option<Shank>>, Failure> {
    let mut shanks = vec![None; instruments.len()];
    for &key in played {
        let wrong = |what: String| Failure::Usage(format!("{keyboard}, key {key}: {what}"));
        let found = Shank::of(&instruments[key - 1]).map_err(|error| wrong(error.to_string()))?;
        shanks[key - 1] = Some(found.ok_or_else(|| wrong("no hammer that meets a string".into()))?);
    }
    Ok(shanks)
}
