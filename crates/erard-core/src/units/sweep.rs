//! Several values or changes, as typed: a list or a range.

use super::number::NumberError;
use super::{Bare, Change, Quantity, Unit};

/// Largest number of values of a sweep.
pub(super) const MAX_VALUES: usize = 100_000;

/// Values or changes of one kind that a number shall have one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// All of them, of one kind.
    pub changes: Vec<Change>,
    /// Unit of the first as typed; `None` without one.
    pub unit: Option<&'static Unit>,
}

impl Sweep {
    /// Reads `FROM..TO:COUNT` or a list. Items of a list are separated by commas, or by semicolons, between which
    /// decimal commas are read. The first item decides for all whether they are values or changes: `-1mm..1mm:3` are
    /// changes by -1, 0 and 1 mm, `=-1mm..1mm:3` are values.
    ///
    /// # Errors
    /// See [`NumberError`].
    pub fn read(text: &str, quantity: Quantity, bare: Bare) -> Result<Self, NumberError> {
        let wrong = || NumberError::Range { found: text.trim().to_owned(), most: MAX_VALUES };
        if let Some((from, rest)) = text.split_once("..") {
            let (to, count) = rest.rsplit_once(':').ok_or_else(wrong)?;
            let count: usize = count.trim().parse().map_err(|_| wrong())?;
            if !(2..=MAX_VALUES).contains(&count) {
                return Err(wrong());
            }
            let (ends, unit) = Self::items(text, &[from, to], quantity, bare)?;
            let [first, last] = [ends[0], ends[1]];
            let between = |from: f64, to: f64, i: usize| {
                let share = i as f64 / (count - 1) as f64;
                let scale = unit.map_or_else(|| bare.unit(quantity).map_or(1.0, |(si, _)| si), |unit| unit.si);
                // As a person would write it: the last digits of the sum mean nothing.
                ((((1.0 - share) * from + share * to) / scale * 1e9).round() / 1e9) * scale
            };
            let changes = (0..count).map(|i| match (first, last) {
                (Change::Set(from), Change::Set(to)) => Change::Set(between(from, to, i)),
                (Change::Add(from), Change::Add(to)) => Change::Add(between(from, to, i)),
                (Change::Multiply(from), Change::Multiply(to)) => {
                    let share = i as f64 / (count - 1) as f64;
                    Change::Multiply((((1.0 - share) * from + share * to) * 1e9).round() / 1e9)
                }
                _ => unreachable!("items are of one kind"),
            });
            return Ok(Sweep { changes: changes.collect(), unit });
        }
        if text.contains(':') {
            return Err(wrong());
        }
        let items = list_items(text)?;
        let (changes, unit) = Self::items(text, &items, quantity, bare)?;
        Ok(Sweep { changes, unit })
    }

    /// Reads the two ends of a range without a count, `LOW..HIGH`, of one kind as in [`Sweep::read`].
    ///
    /// # Errors
    /// See [`NumberError`].
    pub fn read_ends(text: &str, quantity: Quantity, bare: Bare) -> Result<[Change; 2], NumberError> {
        let expected = || NumberError::Text {
            found: text.trim().to_owned(),
            expected: "two increasing numbers, LOW..HIGH".to_owned(),
        };
        let (low, high) = text.split_once("..").ok_or_else(expected)?;
        let (ends, _) = Self::items(text, &[low, high], quantity, bare)?;
        Ok([ends[0], ends[1]])
    }

    /// Reads items of one kind, which the first one decides.
    fn items(
        text: &str,
        items: &[&str],
        quantity: Quantity,
        bare: Bare,
    ) -> Result<(Vec<Change>, Option<&'static Unit>), NumberError> {
        let mixed = || NumberError::Mixed { found: text.trim().to_owned() };
        let mut all: Vec<Change> = Vec::with_capacity(items.len());
        let mut unit = None;
        for (n, item) in items.iter().enumerate() {
            let item = item.trim();
            let own = Change::read(item, quantity, bare)?;
            if n == 0 {
                let number = item.trim_start_matches('=');
                unit = quantity.typed(number, bare).ok().and_then(|typed| typed.unit);
            }
            all.push(match (all.first(), own) {
                (None, own) => own,
                (Some(Change::Set(_)), Change::Set(value)) => Change::Set(value),
                (Some(Change::Multiply(_)), Change::Multiply(factor)) => Change::Multiply(factor),
                // After a change, a number without a sign is one, too.
                (Some(Change::Add(_)), Change::Add(by) | Change::Set(by)) if !item.starts_with('=') => Change::Add(by),
                // After `=`, a sign belongs to the value.
                (Some(Change::Set(_)), Change::Add(value)) if items[0].trim().starts_with('=') => Change::Set(value),
                // A factor's range is `x0.8..1.2:5`, its list `x0.8,1.2`.
                (Some(Change::Multiply(_)), Change::Set(_)) if !item.starts_with('=') => {
                    Change::Multiply(Quantity::Number.read(item, Bare::Si)?)
                }
                _ => return Err(mixed()),
            });
        }
        Ok((all, unit))
    }
}

/// Items of a list, separated by commas, or by semicolons, between which decimal commas are read.
///
/// # Errors
/// [`NumberError::List`] of commas that look decimal: in `0,5mm,1,5mm` a number without a unit stands directly before
/// one with a unit. In `0, 1mm` a blank separates them.
pub fn list_items(text: &str) -> Result<Vec<&str>, NumberError> {
    if text.contains(';') {
        return Ok(text.split(';').collect());
    }
    let items: Vec<&str> = text.split(',').collect();
    let is_digits = |item: &str| !item.is_empty() && item.bytes().all(|byte| byte.is_ascii_digit());
    let is_decimal = |pair: &[&str]| {
        let (before, after) = (pair[0].trim().trim_start_matches(['+', '-', '=', '\u{2212}', 'x', '*']), pair[1]);
        let digits = after.bytes().take_while(u8::is_ascii_digit).count();
        is_digits(before)
            && digits > 0
            && !after[digits..].trim().is_empty()
            && !after[digits..].starts_with(['.', 'e', 'E'])
    };
    if !items.windows(2).any(is_decimal) {
        return Ok(items);
    }
    let mut whole: Vec<String> = Vec::new();
    let mut n = 0;
    while n < items.len() {
        let pair = &items[n..(n + 2).min(items.len())];
        let joined = pair.len() == 2 && is_decimal(pair);
        whole.push(if joined { format!("{},{}", pair[0].trim(), pair[1].trim()) } else { items[n].trim().to_owned() });
        n += if joined { 2 } else { 1 };
    }
    Err(NumberError::List {
        found: text.trim().to_owned(),
        dots: whole.iter().map(|item| item.replacen(',', ".", 1)).collect::<Vec<_>>().join(", "),
        semicolons: if whole.len() == 1 { format!("{};", whole[0]) } else { whole.join("; ") },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Sweep, NumberError> {
        Sweep::read(text, Quantity::Length, Bare::In("mm"))
    }

    #[test]
    fn ranges_and_lists_are_of_one_kind() {
        let add = |mm: &[f64]| mm.iter().map(|mm| Change::Add(mm * 1e-3)).collect::<Vec<_>>();
        let set = |mm: &[f64]| mm.iter().map(|mm| Change::Set(mm * 1e-3)).collect::<Vec<_>>();
        for (text, changes) in [
            ("-1mm..1mm:5", add(&[-1.0, -0.5, 0.0, 0.5, 1.0])),
            ("-1..1:3", add(&[-1.0, 0.0, 1.0])),
            ("+0mm..-1mm:2", add(&[0.0, -1.0])),
            ("=-1mm..1mm:3", set(&[-1.0, 0.0, 1.0])),
            ("0mm..1mm:2", set(&[0.0, 1.0])),
            ("1,2", set(&[1.0, 2.0])),
            ("-1mm, 0, 1mm", add(&[-1.0, 0.0, 1.0])),
            ("0,5mm;1,5mm", set(&[0.5, 1.5])),
            ("0,5 ; 1", set(&[0.5, 1.0])),
            ("=-1,1", set(&[-1.0, 1.0])),
            ("=-1,-2", set(&[-1.0, -2.0])),
            ("x0.8,x1.2", vec![Change::Multiply(0.8), Change::Multiply(1.2)]),
            ("x0.8..1.2:3", vec![Change::Multiply(0.8), Change::Multiply(1.0), Change::Multiply(1.2)]),
        ] {
            let found = read(text).unwrap_or_else(|error| panic!("{text}: {error}")).changes;
            let si = |change: &Change| match *change {
                Change::Set(x) | Change::Add(x) | Change::Multiply(x) => x,
            };
            let is_close = |(a, b): (&Change, &Change)| {
                core::mem::discriminant(a) == core::mem::discriminant(b) && (si(a) - si(b)).abs() < 1e-15
            };
            assert!(found.len() == changes.len() && found.iter().zip(&changes).all(is_close), "{text}: {found:?}");
        }
        assert_eq!(read("1in,2in").unwrap().unit.unwrap().symbol, "in");
        assert_eq!(read("1,2").unwrap().unit, None);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, told) in [
            ("1mm..2mm", "FROM..TO:COUNT"),
            ("1mm:3", "FROM..TO:COUNT"),
            ("1mm..2mm:1", "from 2 to 100000"),
            ("1mm..2mm:many", "FROM..TO:COUNT"),
            ("..2mm:3", "a length"),
            ("1g..2mm:3", "`g` is not one of its units"),
            ("0mm,-1mm", "values and changes are mixed"),
            ("-1mm,=2mm", "mixed"),
            ("x1,=2mm", "mixed"),
            ("-1mm,0,1mm", "type `-1mm, 0.1mm` or `-1mm; 0,1mm`"),
            ("0,5mm,1,5mm", "type `0.5mm, 1.5mm` or `0,5mm; 1,5mm`"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
        }
        for (text, told) in [("0,5mm,1mm", "`0.5mm, 1mm`"), ("14,5@165,14@147", "`14,5@165; 14@147`")] {
            let error = list_items(text).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
        assert_eq!(list_items("8,12").unwrap(), ["8", "12"]);
        assert_eq!(list_items("14,5@165;14@147").unwrap(), ["14,5@165", "14@147"]);
    }
}
