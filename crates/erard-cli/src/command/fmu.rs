//! `erard fmu`.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use erard::instrument_spec::{Base, InstrumentSpec};
use erard_workshop::fmu::{MODEL, Unit, Variable};
use flate2::Compression;
use flate2::write::DeflateEncoder;
use rawzip::time::UtcDateTime;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::out::OwnFile;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::{IS_KEYBOARD, load_instrument_and_text, load_keyboard_and_text};
use crate::output::Output;
use crate::print_line;
use crate::session::Session;

/// Text below the options.
const AFTER: &str = include_str!("help/fmu.txt");

/// Exports an instrument or a keyboard for simulators, as an FMI 2.0 unit for co-simulation.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Fmu {
    /// Instrument: a TOML file, or a built-in name
    #[arg(value_name = "INSTRUMENT", default_value = "concert-grand")]
    instrument: InstrumentSpec,
    /// Keyboard instead of an instrument, 88 keys in one unit: a TOML file, or the name of a built-in one
    #[arg(long, value_name = "KEYBOARD", conflicts_with = "instrument")]
    keyboard: Option<Base>,
    /// File of the unit [default: INSTRUMENT.fmu or KEYBOARD-keyboard.fmu in this folder]
    #[arg(long, short, value_name = "FILE")]
    out_file: Option<PathBuf>,
    /// The library liberard to pack into it
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    force: bool,
}

/// The platform's folder in the archive, the end of its libraries' names, and how the library is called here.
const PLATFORM: Option<(&str, &str)> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Some(("linux64", "so"))
} else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
    Some(("aarch64-linux", "so"))
} else if cfg!(target_os = "macos") {
    Some(("darwin64", "dylib"))
} else if cfg!(all(target_os = "windows", target_arch = "x86_64")) {
    Some(("win64", "dll"))
} else {
    None
};

/// Names that every such library has in it: a function of the standard, and one of ours.
const MARKS: [&[u8]; 2] = [b"fmi2DoStep", b"erard_action_new"];

impl Fmu {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        // As the library will read it: the file's name is in its errors only.
        let (unit, asked, end) = match &self.keyboard {
            None => {
                let (_, text) =
                    load_instrument_and_text(session, &self.instrument).map_err(|failure| match failure {
                        Failure::Usage(text) if text.contains(IS_KEYBOARD) => {
                            Failure::Usage(format!("{text}, or pack all of them: --keyboard {}", self.instrument))
                        }
                        other => other,
                    })?;
                (Unit::of_instrument(&text)?, self.instrument.to_string(), ".fmu")
            }
            Some(asked) => {
                let (keyboard, text) = load_keyboard_and_text(session, asked)?;
                keyboard.instruments()?;
                (Unit::of_keyboard(&text, keyboard.base_text())?, asked.to_string(), "-keyboard.fmu")
            }
        };
        let OwnFile { folder, name } =
            OwnFile::of(session, self.out_file.as_deref(), &asked, end, "unit's", self.force)?;
        let (library, bytes, binary) = self.library(session)?;
        let mut output = Output::files(session, &folder, self.force, &[&name])?;
        let archive = archive(&unit, &binary, &bytes).map_err(|error| Failure::Internal(error.to_string()))?;
        output.stage(session, &name, |w| w.write_all(&archive))?;
        let written = output.commit(session)?;
        let count = |is: fn(&Variable) -> bool| unit.variables.iter().filter(|variable| is(variable)).count();
        let (inputs, parameters) = (count(Variable::is_input), count(Variable::is_parameter));
        print_line!(session, "{} - a unit for FMI 2.0, co-simulation, {} kB", unit.name, archive.len() / 1024);
        print_line!(session);
        print_line!(
            session,
            "  {} variables: {inputs} inputs, {parameters} parameters, the others outputs",
            unit.variables.len()
        );
        print_line!(session, "  library {} as {binary}", shown(&library));
        print_line!(session);
        let answer = Answer::table(session, None).with("name", &unit.name)?.with("bytes", &archive.len())?;
        let answer = answer.with("variables", &unit.variables.len())?.with("inputs", &inputs)?;
        let answer = answer.with("parameters", &parameters)?.with("library", &shown(&library))?;
        Ok(answer.with("library_in_unit", &binary)?.end(session, &written))
    }

    /// The library: its path, its bytes, and its place in the archive.
    fn library(&self, session: &mut Session) -> Result<(PathBuf, Vec<u8>, String), Failure> {
        let Some((platform, end)) = PLATFORM else {
            return Err(Failure::Usage("FMI 2.0 does not support this platform".into()));
        };
        let path = match &self.library {
            Some(path) => path.clone(),
            None => self.beside(end)?,
        };
        let bytes = session.inputs.library(&path).map_err(|why| Failure::Usage(format!("{}: {why}", shown(&path))))?;
        if let Some(mark) = MARKS.iter().find(|mark| !bytes.windows(mark.len()).any(|window| window == **mark)) {
            let mark = String::from_utf8_lossy(mark);
            return Err(Failure::Usage(format!(
                "{}: is not the library liberard: {mark} is missing in it",
                shown(&path)
            )));
        }
        if let Err(why) = whole_library(&bytes) {
            let path = shown(&path);
            return Err(Failure::Usage(format!(
                "{path}: {why}; expected the library liberard, whole and built for this machine: `cargo build --release -p erard-c`"
            )));
        }
        Ok((path, bytes, format!("binaries/{platform}/{MODEL}.{end}")))
    }

    /// The library beside the command, or where it is installed.
    fn beside(&self, end: &str) -> Result<PathBuf, Failure> {
        let command = std::env::current_exe().map_err(|error| Failure::Internal(error.to_string()))?;
        let folder = command.parent().unwrap_or(Path::new("."));
        let built = if cfg!(windows) { format!("erard_c.{end}") } else { format!("liberard_c.{end}") };
        let places = [folder.join(built), folder.join(format!("../lib/liberard.{end}"))];
        places.iter().find(|path| path.is_file()).cloned().ok_or_else(|| {
            let looked: Vec<String> = places.iter().map(|path| shown(path)).collect();
            Failure::Usage(format!(
                "the library liberard was not found at {}. Build it with `cargo build --release -p erard-c`, or name it with --library",
                looked.join(" or ")
            ))
        })
    }
}

/// Bytes of the header of an ELF file of 64 bits, and of an entry of its table of segments.
const ELF_HEADER: u64 = 64;
const ELF_SEGMENT: u64 = 56;
/// The machine for which an ELF library is built.
const ELF_MACHINE: u64 = if cfg!(target_arch = "aarch64") { 183 } else { 62 };

/// Whether a loader finds all that the library's header announces: a simulator that loads a library cut short dies of a
/// signal.
fn whole_library(bytes: &[u8]) -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        // Mach-O, and the libraries of Windows.
        let is_known =
            [&[0xcf, 0xfa, 0xed, 0xfe][..], &[0xca, 0xfe, 0xba, 0xbe], b"MZ"].iter().any(|m| bytes.starts_with(m));
        return if is_known { Ok(()) } else { Err("does not begin as a library does".into()) };
    }
    if !bytes.starts_with(b"\x7fELF\x02\x01") {
        return Err("does not begin as a library does (ELF, 64 bits, little-endian)".into());
    }
    let ends = |at: u64, count: u64, size: u64| at.checked_add(count.checked_mul(size)?);
    let cut = |end: Option<u64>| match end {
        Some(end) if end <= bytes.len() as u64 => Ok(()),
        _ => Err(format!("is cut short: its header announces more than its {} bytes", bytes.len())),
    };
    cut(Some(ELF_HEADER))?;
    let number = |at: u64, size: usize| {
        let own = &bytes[at as usize..at as usize + size];
        own.iter().rev().fold(0_u64, |sum, byte| sum << 8 | u64::from(*byte))
    };
    if number(16, 2) != 3 {
        return Err("is no shared library".into());
    }
    if number(18, 2) != ELF_MACHINE {
        return Err(format!("is built for another machine (ELF's number {})", number(18, 2)));
    }
    let (segments, count, size) = (number(32, 8), number(56, 2), number(54, 2));
    cut(ends(number(40, 8), number(60, 2), number(58, 2)))?;
    cut(ends(segments, count, size))?;
    if count == 0 || size != ELF_SEGMENT {
        return Err("has no segments to load".into());
    }
    for at in (0..count).map(|n| segments + n * ELF_SEGMENT) {
        cut(ends(number(at + 8, 8), 1, number(at + 32, 8)))?;
    }
    Ok(())
}

/// The unit's bytes: the same for the same files and library.
fn archive(unit: &Unit, binary: &str, library: &[u8]) -> Result<Vec<u8>, rawzip::Error> {
    let mut archive = ZipArchiveWriter::new(Vec::new());
    let description = unit.model_description();
    let resources = unit.resources().map(|(path, text)| (path, text.as_bytes(), 0o644));
    let entries = [("modelDescription.xml", description.as_bytes(), 0o644)].into_iter().chain(resources);
    for (name, bytes, mode) in entries.chain([(binary, library, 0o755)]) {
        let mut file = archive.new_file(name).compression_method(CompressionMethod::DEFLATE).unix_permissions(mode);
        // The first day that an archive knows.
        if let Some(date) = UtcDateTime::from_components(1980, 1, 1, 0, 0, 0, 0) {
            file = file.last_modified(date);
        }
        let (mut entry, config) = file.start()?;
        let mut writer = config.wrap(DeflateEncoder::new(&mut entry, Compression::default()));
        writer.write_all(bytes)?;
        let (deflated, size) = writer.finish()?;
        deflated.finish()?;
        entry.finish(size)?;
    }
    archive.finish()
}
