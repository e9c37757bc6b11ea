//! The book's table of derivatives: all numbers of the concert grand at pp, mf and ff, beside differences whose steps
//! have converged, with the times of both.
//!
//! `cargo run --release -p erard-workshop --example derivatives -- [--all] [INSTRUMENT]`; `--all` lists every row.

mod compare;

use compare::{LEVELS, Level, OF, Verdict, level};
use erard::Instrument;
use moreau::SwitchKind;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (flags, names): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|one| one.starts_with("--"));
    let name = names.first().map_or("concert-grand", String::as_str);
    let instrument = Instrument::builtin(name)?;
    for name in LEVELS {
        let level = level(&instrument, name);
        if flags.iter().any(|flag| flag == "--all") {
            list(&level);
        }
        tell(&level, &instrument);
    }
    let _ = SwitchKind::Unresolved;
    Ok(())
}

fn list(level: &Level) {
    for row in &level.rows {
        println!(
            "{:3} {:22} {:30} {:10.3e} {:10.3e} | {:10.3e} +- {:8.1e} [{:10.3e} {:10.3e}] {:4} {:?}",
            level.name,
            row.of,
            row.by,
            row.derivative,
            row.shorter,
            row.differences,
            row.scatter,
            row.sides[0],
            row.sides[1],
            row.window,
            row.verdict
        );
    }
}

fn tell(level: &Level, instrument: &Instrument) {
    println!(
        "{}: switches {:?}, gradient {:.2} s, differences {:.2} s",
        level.name, level.found.switches, level.gradient_s, level.differences_s
    );
    for of in OF {
        let count = |verdict: Verdict| level.rows.iter().filter(|row| row.of == of && row.verdict == verdict).count();
        println!(
            "  {of}: within {}, scatter {}, apart {}, refused {}, no effect {}",
            count(Verdict::Within),
            count(Verdict::Scatter),
            count(Verdict::Apart),
            count(Verdict::Refused),
            count(Verdict::NoEffect)
        );
    }
    for one in &level.found.refused {
        println!(
            "  {} {} {:?} {:?} {:?}",
            one.of,
            one.by,
            one.slopes,
            one.event.as_ref().map(|e| e.told(instrument)),
            one.sides
        );
    }
}
