//! `erard live`.

use erard::parameter::Quantity;
use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::{self, IsTerminal, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use clap::Args;
use erard::instrument_spec::Base;
use erard_live::profile::{Profile, Sensed};
use erard_live::stream::{Head, Of, Reader, SensorUnit};
use erard_live::{Event, Live as Keys, LiveError, Options, SensorKind};
use erard_workshop::cores;

use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::load_keyboard;
use crate::live::feed::{Line, lines};
use crate::live::latency::{Clock, Latency};
use crate::live::report::StreamSummary;
use crate::live::{Bits, Sounding, Wire};
use crate::number::{between, number, whole};
use crate::output::Output;
use crate::print_line;
use crate::session::Session;
use crate::warn;

/// What stands below the options.
const AFTER: &str = include_str!("help/live.txt");

/// What the sensors sit on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Sensor {
    /// The keys of a real action: their motion is prescribed
    Action,
    /// Switches or controllers: a hand of 200 g with at most 60 N follows their depth
    Light,
}

/// Plays a stream of sensed keys, and sends MIDI as the hammers meet the strings.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Live {
    /// The stream: a file or pipe, `-` for standard input
    #[arg(value_name = "STREAM", default_value = "-")]
    stream: PathBuf,
    /// Keyboard: a TOML file, or the name of a built-in one
    #[arg(long, value_name = "KEYBOARD", default_value = "concert-grand")]
    keyboard: Base,
    /// Sampling rate of a log without times, such as a converter's, Hz. The header names the keys of the
    /// columns, such as `40,41`, or is `key,raw`
    #[arg(long, value_name = "HZ", value_parser = between(Quantity::Frequency, "Hz", 20.0, 1e6), allow_hyphen_values = true)]
    rate: Option<f64>,
    /// Device that carries the sensors
    #[arg(long, value_enum, default_value = "action")]
    sensor: Sensor,
    /// Distance of the sensed place from the balance pin, mm, in front of the pin or behind it [default: the key's
    /// front]
    #[arg(long, value_name = "MM", value_parser = distance, allow_hyphen_values = true)]
    sensor_at: Option<f64>,
    /// Full travel of the device, mm: it is scaled to the key's dip. For `--sensor light` and a stream in mm
    #[arg(long, value_name = "MM", value_parser = distance, allow_hyphen_values = true)]
    travel: Option<f64>,
    /// Profile of the sensors, as `erard calibrate` writes it; for a stream of raw readings, pressures or contacts
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Send notes before the impact, as early as 0.2 ms and 1 % of its speed allow
    #[arg(long)]
    ahead: bool,
    /// Bits of a velocity
    #[arg(long, value_enum, default_value = "7")]
    velocity_bits: Bits,
    /// Channel, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u8>(1, 16), allow_negative_numbers = true)]
    channel: u8,
    /// Output of the MIDI bytes: a pipe, a device, or a file. A name that ends in .mid makes a Standard MIDI File, one
    /// that ends in .csv a table of the notes with their hammer speeds [default: `-`, standard output]
    #[arg(long, short, value_name = "FILE")]
    out_file: Option<PathBuf>,
    /// MIDI port of the system, by part of its name, instead of --out-file
    #[arg(long, value_name = "NAME")]
    midi_port: Option<String>,
    /// Release all keys if a pipe has sent nothing for this time, s. Not for contacts, which send edges only
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = between(Quantity::Time, "s", 0.05, 3600.0), allow_hyphen_values = true)]
    stall: f64,
    /// Replace FILE if it exists
    #[arg(long)]
    force: bool,
}

/// A distance in either direction, mm.
fn distance(text: &str) -> Result<f64, String> {
    let mm = number(Quantity::Length, "mm")(text)?;
    Some(mm).filter(|mm| (0.5..=500.0).contains(&mm.abs())).ok_or_else(|| "expected 0.5 to 500 mm".to_owned())
}

/// What came of lines so far.
#[derive(Default)]
struct Heard {
    line: u64,
    malformed: u64,
    first: Option<(u64, String)>,
    late_s: Vec<f64>,
}

impl Live {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let profile = self.calibration.as_deref().map(|path| load_profile(session, path)).transpose()?;
        let keyboard = load_keyboard(session, &self.keyboard)?;
        let (input, is_file) = self.input(session)?;
        let feed = lines(input);
        let mut heard = Heard::default();
        let mut reader = self.head(&feed, &mut heard)?;
        let options = self.options(session, reader.quantity(), profile.as_ref(), is_file)?;
        let instruments = keyboard.instruments()?;
        let mut wire = self.wire(session)?;
        let mut progress = session.progress("preparing keys");
        let made = Keys::new(&instruments, profile.as_ref(), options, &mut |share| progress.tell(share));
        drop(progress);
        let mut keys = made.map_err(|error| failed(&keyboard.name, error))?;
        if !is_file && !session.printer.is_quiet() {
            warn!(session, "ready: {} keys of {}", instruments.len(), keyboard.name);
        }
        self.play(session, &mut keys, &feed, &mut reader, &mut wire, &mut heard, is_file)?;
        let report = keys.report();
        if let (0, Some((line, what))) = (report.samples, &heard.first) {
            return Err(Failure::Usage(format!("{}, line {line}: {what}; no line is a sample", self.name())));
        }
        let report = erard_live::Report { longest_on_a_cable_s: wire.longest_on_a_cable_s(), ..report };
        let summary = StreamSummary {
            stream: self.name(),
            keyboard: keyboard.name.clone(),
            report,
            malformed: heard.malformed,
            first_malformed: heard.first,
            latency: (!is_file).then(|| Latency::of(heard.late_s)),
        };
        self.finish(session, &mut wire, &summary)
    }

    fn out(&self) -> &Path {
        self.out_file.as_deref().unwrap_or(Path::new("-"))
    }

    fn is_stdout(&self) -> bool {
        self.out() == Path::new("-")
    }

    fn name(&self) -> String {
        if self.stream == Path::new("-") { "standard input".into() } else { shown(&self.stream) }
    }

    /// The stream, and whether it is a file, whose lines come as fast as they are read.
    fn input(&self, session: &mut Session) -> Result<(Box<dyn Read + Send>, bool), Failure> {
        if self.stream == Path::new("-") {
            session.inputs.standard_input();
            return Ok((Box::new(io::stdin()), false));
        }
        let unread = |error| Failure::Usage(format!("{}: cannot be read: {error}", self.name()));
        let file = session.inputs.open(&self.stream).map_err(unread)?;
        let kind = file.metadata().map_err(unread)?;
        if kind.is_dir() {
            return Err(Failure::Usage(format!("{}: is a folder; expected a file or a pipe", self.name())));
        }
        Ok((Box::new(file), kind.is_file()))
    }

    /// The stream's head.
    fn head(&self, feed: &Receiver<io::Result<Line>>, heard: &mut Heard) -> Result<Reader, Failure> {
        let wrong = |what: String| Failure::Usage(format!("{}: {what}", self.name()));
        while let Ok(line) = feed.recv() {
            let line = line.map_err(|error| wrong(format!("cannot be read: {error}")))?;
            heard.line += 1;
            let text = line.text.trim();
            if !text.is_empty() && !text.starts_with('#') {
                return stream_reader(text, self.rate).map_err(wrong);
            }
        }
        Err(wrong("it is empty; expected a header such as `time_s,key,mm`, then a line for each sample".into()))
    }

    /// The keys that a file moves.
    fn moved(&self, session: &mut Session) -> Result<BTreeSet<usize>, Failure> {
        let mut all = BTreeSet::new();
        let feed = lines(self.input(session)?.0);
        let mut reader = self.head(&feed, &mut Heard::default())?;
        // A line that cannot be read is reported when it is played.
        for line in feed.into_iter().flatten() {
            for sample in reader.received(&line.text).unwrap_or_default() {
                if let Of::Key(key) = sample.of {
                    all.insert(key);
                }
            }
        }
        Ok(all)
    }

    fn options(
        &self,
        session: &mut Session,
        quantity: SensorUnit,
        profile: Option<&Profile>,
        is_file: bool,
    ) -> Result<Options, Failure> {
        let wrong = |what: &str| Err(Failure::Usage(format!("{}: {what}", self.name())));
        match (quantity, profile) {
            (SensorUnit::Raw | SensorUnit::Pressure, None) => {
                return wrong(
                    "raw readings and pressures need --calibration FILE; `erard calibrate` makes one of readings",
                );
            }
            (SensorUnit::Contacts, None) => {
                return wrong("contacts need --calibration FILE; `erard calibrate --contacts MM,MM` makes one");
            }
            (SensorUnit::Contacts, Some(Profile { sensed: Sensed::Contacts(_), .. }))
                if self.ahead || self.sensor_at.is_some() =>
            {
                return wrong("--ahead and --sensor-at go with sensors of a key's whole travel, not with contacts");
            }
            (SensorUnit::Contacts, Some(Profile { sensed: Sensed::Contacts(_), .. })) => {}
            (SensorUnit::Contacts, Some(_)) => {
                return wrong("the calibration has no [contacts]; `erard calibrate --contacts MM,MM` makes one");
            }
            (_, Some(Profile { sensed: Sensed::Contacts(_), .. })) => {
                return wrong("the calibration is one of contacts; expected the header `time_us,key,contact,state`");
            }
            (quantity, Some(Profile { sensed: Sensed::Hammers(_), .. })) => {
                if quantity != SensorUnit::Raw {
                    return wrong("the calibration is one of hammers; expected the header `time_us,key,raw`");
                }
                if self.ahead || self.sensor_at.is_some() {
                    return wrong("--ahead and --sensor-at go with sensors of keys, not of hammers");
                }
            }
            (SensorUnit::Pressure, Some(profile)) if !profile.pressure_is_depth => {
                return wrong(
                    "polyphonic pressure is a force on most devices, and no depth. If it is the key's depth on this \
                     one, say so in the calibration: polyphonic_pressure_is_depth = true",
                );
            }
            (SensorUnit::Millimetres | SensorUnit::Newtons, Some(_)) => {
                return wrong("--calibration converts raw readings; this stream has millimetres or newtons");
            }
            _ => {}
        }
        let travels = self.sensor == Sensor::Light && quantity == SensorUnit::Millimetres;
        if self.travel.is_some() && !travels {
            return wrong("--travel goes with --sensor light and a stream of mm");
        }
        if self.sensor_at.is_some() && (quantity == SensorUnit::Newtons || self.sensor == Sensor::Light) {
            return wrong("--sensor-at goes with --sensor action; forces act at the key's front");
        }
        let sensor = match (quantity, self.sensor) {
            (SensorUnit::Newtons, _) => SensorKind::Force,
            (_, Sensor::Action) => SensorKind::Action,
            (_, Sensor::Light) => SensorKind::Light,
        };
        let metres = |mm: Option<f64>| mm.map(|mm| 1e-3 * mm.abs());
        Ok(Options {
            sensor,
            quantity,
            sensor_at_m: metres(self.sensor_at),
            travel_m: metres(self.travel),
            ahead: self.ahead,
            moved: is_file.then(|| self.moved(session)).transpose()?,
            threads: cores::count(),
        })
    }

    /// Until the stream ends.
    #[allow(clippy::too_many_arguments)]
    fn play(
        &self,
        session: &Session,
        keys: &mut Keys,
        feed: &Receiver<io::Result<Line>>,
        reader: &mut Reader,
        wire: &mut Wire,
        heard: &mut Heard,
        is_file: bool,
    ) -> Result<(), Failure> {
        let (mut clock, mut failure, mut waits) = (Clock::new(), None, false);
        let mut progress = session.counting_progress("playing");
        loop {
            let line = match feed.recv_timeout(Duration::from_secs_f64(self.stall)) {
                Ok(line) => line,
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) if waits || is_file || keys.is_sparse() || keys.are_up() => continue,
                Err(RecvTimeoutError::Timeout) => {
                    waits = true;
                    let begins_s = keys.begins_s();
                    keys.stalled(&mut |event| failure = failure.take().or(wire.send(&event, begins_s).err()));
                    continue;
                }
            };
            let line = line.map_err(|error| Failure::Usage(format!("{}: cannot be read: {error}", self.name())))?;
            waits = false;
            heard.line += 1;
            match reader.received(&line.text) {
                Ok(samples) if samples.is_empty() && reader.take_restart() => {
                    clock = Clock::new();
                    keys.restart();
                }
                Ok(samples) => samples.into_iter().for_each(|sample| {
                    clock.came(sample.time_s, line.came);
                    let begins_s = keys.begins_s();
                    keys.take(&sample, &mut |event| {
                        failure = failure.take().or(wire.send(&event, begins_s).err());
                        if let Event::On { time_s, known_s, .. } = event
                            && !is_file
                            && known_s >= time_s
                        {
                            heard.late_s.push(clock.since_s(time_s));
                        }
                    });
                }),
                Err(fault) => {
                    heard.malformed += 1;
                    heard.first.get_or_insert_with(|| (heard.line, fault.to_string()));
                }
            }
            if let Some(source) = failure.take() {
                return Err(Failure::write(self.out(), source));
            }
            if heard.line.is_multiple_of(4096) {
                progress.counted(|| format!("playing, {} lines", heard.line));
            }
        }
        let begins_s = keys.begins_s();
        keys.let_go(&mut |event| failure = failure.take().or(wire.send(&event, begins_s).err()));
        failure.map_or(Ok(()), |source| Err(Failure::write(self.out(), source)))
    }

    /// Where bytes go.
    fn wire(&self, session: &Session) -> Result<Wire, Failure> {
        if let Some(name) = &self.midi_port {
            return self.port(&session.sounding, name);
        }
        if self.is_stdout() {
            if session.printer.wants_json() {
                return Err(Failure::Usage("--json answers on standard output; name a file with --out-file".into()));
            }
            if io::stdout().is_terminal() {
                let what = "MIDI bytes would go to this terminal; name a file or a pipe with --out-file";
                return Err(Failure::Usage(what.into()));
            }
            return Ok(Wire::bytes(&session.sounding, Box::new(io::stdout()), self.velocity_bits, self.channel - 1));
        }
        if self.ends_in("mid") {
            if self.velocity_bits == Bits::Sixteen {
                return Err(Failure::Usage("--velocity-bits 16: a Standard MIDI File holds 7 or 14 bits".into()));
            }
            self.staged(session)?;
            return Ok(Wire::piece());
        }
        let refused = |source| Failure::write(self.out(), source);
        if self.out().exists() && !self.is_kept() {
            let device = OpenOptions::new().write(true).open(self.out()).map_err(refused)?;
            return Ok(Wire::bytes(&session.sounding, Box::new(device), self.velocity_bits, self.channel - 1));
        }
        if session.inputs.is_one(self.out()) {
            return Err(Failure::Usage(format!("{}: is the stream; name another file", shown(self.out()))));
        }
        self.staged(session)?;
        if self.ends_in("csv") {
            return Ok(Wire::table());
        }
        Ok(Wire::kept(&session.sounding, self.velocity_bits, self.channel - 1))
    }

    #[cfg(feature = "ports")]
    fn port(&self, sounding: &Sounding, name: &str) -> Result<Wire, Failure> {
        use erard_midi::ports::Output as Port;
        /// A port takes a message at a time.
        struct Sink(Port);
        impl io::Write for Sink {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0.send(bytes).map_err(io::Error::other)?;
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        if self.velocity_bits == Bits::Sixteen {
            return Err(Failure::Usage("--velocity-bits 16: ports take MIDI 1.0, 7 or 14 bits".into()));
        }
        let port = Port::open(name).map_err(|error| Failure::Usage(format!("--midi-port {name}: {error}")))?;
        Ok(Wire::bytes(sounding, Box::new(Sink(port)), self.velocity_bits, self.channel - 1))
    }

    #[cfg(not(feature = "ports"))]
    fn port(&self, _: &Sounding, name: &str) -> Result<Wire, Failure> {
        Err(Failure::Usage(format!(
            "--midi-port {name}: this program was built without MIDI ports. Build it with `cargo build --release -p erard-cli \
             --features ports` (on Linux that needs ALSA's headers, Debian: libasound2-dev), or let --out-file name a pipe or \
             a device such as /dev/snd/midiC1D0"
        )))
    }

    fn ends_in(&self, end: &str) -> bool {
        self.out().extension().is_some_and(|own| own.eq_ignore_ascii_case(end))
    }

    /// Whether it is a file that is kept, and no pipe or device.
    fn is_kept(&self) -> bool {
        self.out().metadata().is_ok_and(|found| found.is_file() || found.is_dir())
    }

    /// The file that appears when all is done.
    fn staged(&self, session: &Session) -> Result<(Output, String), Failure> {
        let folder = self.out().parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = self.out().file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok((Output::files(session, folder, self.force, &[&name])?, name))
    }

    fn finish(&self, session: &mut Session, wire: &mut Wire, summary: &StreamSummary) -> Result<Answer, Failure> {
        let mut answer = Answer::of(&summary.json()?)?;
        if let Some(bytes) = wire.file(self.velocity_bits).map_err(Failure::Internal)? {
            let (mut output, name) = self.staged(session)?;
            output.stage(session, &name, |writer| writer.write_all(&bytes))?;
            answer = answer.files(&output.commit(session)?);
        }
        if let Some(notes) = wire.notes(self.velocity_bits) {
            let (mut output, name) = self.staged(session)?;
            output.table(session, &name, &notes)?;
            answer = answer.files(&output.commit(session)?);
        }
        if let Some(warning) = summary.warning() {
            warn!(session, "{warning}");
        }
        if self.is_stdout() && self.midi_port.is_none() {
            if !session.printer.is_quiet() {
                summary.text().into_iter().for_each(|line| warn!(session, "{line}"));
            }
        } else {
            summary.text().into_iter().for_each(|line| print_line!(session, "{line}"));
            answer = answer.end_without_files(session);
        }
        Ok(answer)
    }
}

/// The reader of a stream's lines after its first one; with a rate, Hz, of rows without times.
///
/// # Errors
/// What is wrong with the first line.
pub(super) fn stream_reader(first: &str, rate_hz: Option<f64>) -> Result<Reader, String> {
    match (Head::parse(first), rate_hz) {
        (Ok(_), Some(_)) => Err(format!("the first line is `{first}`: it has times; expected no --rate")),
        (Ok(head), None) => Ok(Reader::new(head)),
        (Err(_), Some(rate_hz)) => Reader::of_rows(first, rate_hz).map_err(|fault| fault.to_string()),
        (Err(fault), None) if Reader::of_rows(first, 1.0).is_ok() => {
            Err(format!("{fault}. Rows without times need their number a second, --rate HZ"))
        }
        (Err(fault), None) => Err(fault.to_string()),
    }
}

fn load_profile(session: &mut Session, path: &Path) -> Result<Profile, Failure> {
    let (name, bytes) = session.inputs.bytes(path)?;
    let text = erard::instrument::utf8(&bytes, &name)?;
    let profile = Profile::parse(text).map_err(|fault| Failure::Usage(format!("{name}: {fault}")))?;
    session.provenance.used("calibration", &name, Some(&name), &bytes);
    Ok(profile)
}

fn failed(keyboard: &str, error: LiveError) -> Failure {
    match error {
        LiveError::Work(error) => error.into(),
        other => Failure::Usage(format!("{keyboard}: {other}")),
    }
}
