//! `erard check`.

use std::path::{Path, PathBuf};

use clap::Args;
use erard::instrument::{Instrument, InstrumentFile};
use erard::keyboard::{Graded, Grading, KEYS, Keyboard, is_keyboard};
use erard::stroke::Series;
use erard_lab::compare::LONGEST_S;

use crate::failure::Failure;
use crate::inputs::{self, shown};
use crate::say;

/// Checks an instrument or keyboard (TOML) or stroke (CSV) file and says what it holds.
#[derive(Debug, Args)]
pub struct Check {
    /// The file: an instrument or keyboard ends in `.toml`, a stroke in `.csv`
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Check {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let extension = self.file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match extension.as_str() {
            "toml" => {
                let (name, bytes) = inputs::bytes(&self.file)?;
                if is_keyboard(&String::from_utf8_lossy(&bytes)) {
                    self.keyboard(&name, &bytes)
                } else {
                    Self::instrument(&name, &bytes)
                }
            }
            "csv" => self.stroke(),
            _ => Err(Failure::Usage(format!(
                "{}: cannot tell what this is from its name: an instrument or keyboard ends in .toml, a stroke in .csv",
                shown(&self.file)
            ))),
        }
    }

    fn instrument(name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let file = InstrumentFile::parse_bytes(bytes, name)?;
        let i: &Instrument = &file.instrument;
        say!("{name}: an instrument, \"{}\"", i.name);
        say!();
        for body in &i.bodies {
            let on = body.parent.map_or("the ground", |p| &i.bodies[p].name);
            say!(
                "  body    {:<18} on {:<10} {:>7.1} g  {:>10.3e} kg m2  friction {:>8.2e} N m",
                body.name,
                on,
                body.mass_kg * 1e3,
                body.inertia_kg_m2,
                body.friction_torque_n_m
            );
        }
        for spring in &i.springs {
            say!("  spring  {:<18} {:>9.4} N m on {}", spring.name, spring.torque_n_m, i.bodies[spring.body].name);
        }
        for zone in &i.zones {
            let name = |b: Option<usize>| b.map_or("ground", |b| &i.bodies[b].name);
            let friction = if zone.friction_coefficient > 0.0 {
                format!(", friction {}", zone.friction_coefficient)
            } else {
                String::new()
            };
            let felt = &zone.felt;
            let loss = if felt.hunt_crossley > 0.0 {
                format!("a {} s/m", felt.hunt_crossley)
            } else {
                format!("b {:.1e}", felt.damping)
            };
            say!(
                "  zone    {:<18} {} - {}, k {:.1e}, r {}, {loss}{friction}",
                zone.name,
                name(zone.disc_body),
                name(zone.curve_body),
                felt.stiffness,
                felt.exponent
            );
        }
        say!();
        say!(
            "  {} bodies, {} springs, {} zones, {} screws, {} outlines of its own; {} numbers, {} of them without a source",
            i.bodies.len(),
            i.springs.len(),
            i.zones.len(),
            i.screws.len(),
            i.parts.len(),
            file.provenance.numbers.len(),
            file.provenance.bare().count()
        );
        let outlived = file.provenance.outlived_notes();
        if !outlived.is_empty() {
            say!();
            say!("  Changed, while the note beside it still speaks of a built-in instrument's value:");
        }
        for one in outlived {
            let note = one.number.citation.and_then(|citation| citation.note).unwrap_or_default();
            let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            let (line, key, now) = (one.number.line, one.number.key, numbers(&one.number.values));
            say!("  line {line:>4}  {key}: {now}; {} in {}: \"{note}\"", numbers(&one.was), one.builtin);
        }
        Ok(())
    }

    /// Every key's instrument is read, so that a file that is called sound has none that is not.
    fn keyboard(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let keyboard = Keyboard::parse_bytes(bytes, name, self.file.parent().unwrap_or(Path::new("")))?;
        keyboard.instruments()?;
        say!("{name}: a keyboard, \"{}\", around key {}", keyboard.name, keyboard.base_key);
        say!();
        let points = || keyboard.gradings.iter().flat_map(|grading| &grading.curve.points);
        for Grading { name, graded, curve } in &keyboard.gradings {
            let (kind, unit) = match graded {
                Graded::AddedMass { .. } => ("mass", " g"),
                Graded::Factor { .. } => ("factor", ""),
                Graded::Shift { .. } => ("shift", " mm"),
            };
            let [low, high] = [1, KEYS].map(|key| curve.at(key));
            say!("  {kind:<8}{name:<40} {low}{unit} in the bass, {high}{unit} in the treble");
        }
        say!();
        say!(
            "  {} gradings of {} points, {} of them without a source; the instruments of all {KEYS} keys are sound",
            keyboard.gradings.len(),
            points().count(),
            points().filter(|point| point.citation.is_none()).count()
        );
        Ok(())
    }

    fn stroke(&self) -> Result<(), Failure> {
        let name = shown(&self.file);
        let series = Series::read_opened(inputs::open(&self.file), &name)?;
        let times = series.times_s();
        say!("{name}: a stroke of {} rows, {} to {} s", times.len(), series.start_s(), series.end_s());
        say!();
        let steps = times.windows(2).map(|t| t[1] - t[0]);
        let (shortest, longest) = steps.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        say!("  time      sampled every {:.4} to {:.4} ms", shortest * 1e3, longest * 1e3);
        if series.end_s() - series.start_s() > LONGEST_S {
            say!(
                "            too long for `compare` as a whole: `--duration {LONGEST_S}` compares its first {LONGEST_S} s"
            );
        }
        let range =
            |values: &[f64]| values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        if let Some(force) = &series.force {
            let (low, high) = range(force.forces_n());
            say!("  force     {low:.4} to {high:.4} N");
        }
        if let Some(position) = &series.position {
            let (low, high) = range(position.positions_m());
            say!("  position  {:.4} to {:.4} mm", low * 1e3, high * 1e3);
        }
        if let Some(head) = &series.hammer_head {
            let (low, high) = range(head.positions_m());
            say!("  hammer    {:.4} to {:.4} mm", low * 1e3, high * 1e3);
        }
        Ok(())
    }
}
