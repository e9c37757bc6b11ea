//! Lengths in the unit of the reader's ruler.

use clap::Args;
use erard_workshop::digits::{plain, rounds_to_zero};

/// Millimetres in an inch.
pub(crate) const MM_PER_INCH: f64 = 25.4;

/// Whether lengths are shown in inches.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Args)]
pub(crate) struct Lengths {
    /// Show lengths in inches. JSON and CSV stay in millimetres
    #[arg(long)]
    inches: bool,
}

impl Lengths {
    /// The unit's name.
    #[must_use]
    pub(crate) fn unit(self) -> &'static str {
        if self.inches { "in" } else { "mm" }
    }

    /// A length in mm as a number of the unit; `decimals` are those of millimetres. Inches are read in thousandths, as
    /// rulers of the trade are.
    #[must_use]
    pub(crate) fn number(self, mm: f64, decimals: usize) -> String {
        if self.inches {
            let decimals = [2, 3, 3].get(decimals).copied().unwrap_or(4);
            plain(mm / MM_PER_INCH, decimals)
        } else {
            plain(mm, decimals)
        }
    }

    /// The same with the unit.
    #[must_use]
    pub(crate) fn text(self, mm: f64, decimals: usize) -> String {
        format!("{} {}", self.number(mm, decimals), self.unit())
    }

    /// The same with a sign, unless it rounds to nothing.
    #[must_use]
    pub(crate) fn signed(self, mm: f64, decimals: usize) -> String {
        let text = self.text(mm.abs(), decimals);
        let sign = if mm < 0.0 { "-" } else { "+" };
        format!("{}{text}", if rounds_to_zero(&text) { "" } else { sign })
    }

    /// Inches, whatever was asked for.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn inches() -> Self {
        Lengths { inches: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 46 mm are 1.811 in; a tenth of a millimetre is four thousandths.
    #[test]
    fn lengths_in_both_units() {
        assert_eq!(Lengths::default().text(46.04, 1), "46.0 mm");
        assert_eq!(Lengths::inches().text(46.0, 1), "1.811 in");
        assert_eq!(
            (Lengths::inches().signed(-0.1, 1), Lengths::default().signed(0.1, 2)),
            ("-0.004 in".into(), "+0.10 mm".into())
        );
        assert_eq!(
            (Lengths::default().signed(-0.04, 1), Lengths::default().text(-0.04, 1)),
            ("0.0 mm".into(), "0.0 mm".into())
        );
    }
}
