//! Simulates the effect of each cause on each reading, and prints `src/diagnose/effects.csv`: `.ci/regenerate effects`.

use erard::instrument::{Instrument, InstrumentFile};
use erard_workshop::diagnose::effects_csv;
use erard_workshop::sample::Sampled;
use erard_workshop::worklist::{ReadingQuantity, Readings};

/// The samples used: the first five from 1001 on that were sound when they were chosen. They are kept while they are
/// sound: an end of a usual range that moves would choose others, and move every effect by what grands differ.
const SAMPLES: [u32; 5] = [1003, 1007, 1009, 1017, 1018];
const GRAND: &str = "concert-grand";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let go_on = &mut |_: f64| true;
    let text = Instrument::builtin_text(GRAND).ok_or("no such instrument")?;
    let sampled = Sampled::of_file(text, GRAND, go_on)?;
    let mut grands = Vec::new();
    for number in SAMPLES {
        let grand = InstrumentFile::parse(&sampled.text(number, go_on)?, GRAND)?.instrument;
        let readings = Readings::of(&grand, go_on)?;
        if let Some(out) = ReadingQuantity::ALL.into_iter().find(|quantity| readings.is_out(*quantity, 40)) {
            return Err(format!("sample {number} is not sound any more: {out:?}").into());
        }
        grands.push(grand);
    }
    let numbers = SAMPLES.map(|number| number.to_string()).join(" ");
    let title = format!("Simulated on the sound samples {numbers} of {GRAND}: change of each reading");
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
