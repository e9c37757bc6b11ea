//! Outdated notes: a number was changed, but kept the note of the built-in instrument that it comes from.

use super::provenance::{CitedNumber, Provenance};
use super::{Instrument, InstrumentFile};

/// A number that was changed but still carries the note of the built-in instrument that it comes from. The note refers
/// to the old value.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlivedNote {
    /// The number in the file.
    pub number: CitedNumber,
    /// Value in the built-in instrument.
    pub was: Vec<f64>,
    /// Name of that instrument, e.g. `concert-grand`.
    pub builtin: &'static str,
}

impl Provenance {
    /// Returns the numbers that differ from those of a built-in instrument but have kept its note word for word.
    #[must_use]
    pub fn outlived_notes(&self) -> Vec<OutlivedNote> {
        let note = |number: &CitedNumber| number.citation.as_ref().and_then(|citation| citation.note.clone());
        let builtin = |name: &'static str| Some((name, InstrumentFile::builtin(name)?.provenance.numbers));
        let builtins: Vec<(&'static str, Vec<CitedNumber>)> = Instrument::builtin_names().filter_map(builtin).collect();
        let outlived = |number: &CitedNumber| {
            let text = note(number)?;
            let twins: Vec<(&'static str, &CitedNumber)> = builtins
                .iter()
                .flat_map(|(name, numbers)| numbers.iter().map(move |number| (*name, number)))
                .filter(|(_, twin)| twin.key == number.key && note(twin).as_deref() == Some(&text))
                .collect();
            let (name, twin) = *twins.first()?;
            let is_true = twins.iter().any(|(_, twin)| twin.values == number.values);
            (!is_true).then(|| OutlivedNote { number: number.clone(), was: twin.values.clone(), builtin: name })
        };
        self.numbers.iter().filter_map(outlived).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A capstan that was moved by hand keeps the note of where it was, and is found; the built-in files have no such
    /// notes.
    #[test]
    fn a_note_that_its_number_has_outlived_is_found() {
        for name in Instrument::builtin_names() {
            assert_eq!(InstrumentFile::builtin(name).unwrap().provenance.outlived_notes(), [], "{name}");
        }
        let text = Instrument::builtin_text("concert-grand").unwrap();
        let moved = text.replace("value = [142.23, 18.32]", "value = [132.23, 18.32]");
        let found = InstrumentFile::parse(&moved, "moved").unwrap().provenance.outlived_notes();
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!((one.number.key.as_str(), one.builtin), ("zone.capstan_heel.disc.center_mm", "concert-grand"));
        assert_eq!((&one.number.values[..], &one.was[..]), (&[132.23, 18.32][..], &[142.23, 18.32][..]));
    }
}
