//! Simulates the effect of each cause on each reading, and prints `src/diagnose/effects.csv`: `.ci/regenerate effects`.

use erard::instrument::{Instrument, InstrumentFile};
use erard_workshop::diagnose::effects_csv;
use erard_workshop::sample::Sampled;
use erard_workshop::worklist::{ReadingQuantity, Readings};

/// First sample tried, and number of sound grands used.
const FIRST: u32 = 1001;
const GRANDS: usize = 5;
const GRAND: &str = "concert-grand";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let go_on = &mut |_: f64| true;
    let text = Instrument::builtin_text(GRAND).ok_or("no such instrument")?;
    let sampled = Sampled::of_file(text, GRAND, go_on)?;
    let (mut grands, mut numbers) = (Vec::new(), Vec::new());
    for number in FIRST.. {
        let grand = InstrumentFile::parse(&sampled.text(number, go_on)?, GRAND)?.instrument;
        let readings = Readings::of(&grand, go_on)?;
        if ReadingQuantity::ALL.into_iter().all(|quantity| !readings.is_out(quantity, 40)) {
            eprintln!("sample {number}");
            grands.push(grand);
            numbers.push(number.to_string());
        }
        if grands.len() == GRANDS {
            break;
        }
    }
    let title = format!("Simulated on the sound samples {} of {GRAND}: change of each reading", numbers.join(" "));
    let mut told = 0;
    let mut progress = |share: f64| {
        let percent = (100.0 * share) as u32;
        if percent > told {
            told = percent;
            eprintln!("{percent} %");
        }
        true
    };
    print!("{}", effects_csv(&grands, &title, &mut progress)?);
    Ok(())
}
