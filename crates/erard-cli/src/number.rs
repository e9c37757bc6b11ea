//! Numbers as options: each says in its message what it expects.

/// A number with or without its unit, e.g. `5` and `5N`. `expected` completes the message "expected ...". The range is
/// for whoever uses the number to check.
pub(crate) fn number(
    unit: &'static str,
    expected: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| text.strip_suffix(unit).unwrap_or(text).trim_end().parse().map_err(|_| format!("expected {expected}"))
}

/// A whole number from `least` to `most`.
pub(crate) fn whole<T: TryFrom<u64>>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let found = text.parse::<u64>().ok().filter(|number| (least..=most).contains(number));
        found.and_then(|number| T::try_from(number).ok()).ok_or_else(|| {
            let upward = format!("expected a whole number from {least}");
            if most == u64::MAX { upward } else { format!("{upward} to {most}") }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{number, whole};

    #[test]
    fn a_unit_may_follow_a_number() {
        let newtons = number("N", "a number of N, e.g. 5N");
        assert_eq!([newtons("5"), newtons("5N"), newtons("2.5 N")], [Ok(5.0), Ok(5.0), Ok(2.5)]);
        assert_eq!(newtons("5kg"), Err("expected a number of N, e.g. 5N".to_owned()));
    }

    #[test]
    fn a_whole_number_outside_its_range_is_refused_with_the_range() {
        let channel = whole::<u8>(1, 16);
        assert_eq!([channel("1"), channel("16")], [Ok(1), Ok(16)]);
        for wrong in ["0", "17", "-1", "1.5", "x", ""] {
            assert_eq!(channel(wrong), Err("expected a whole number from 1 to 16".to_owned()), "{wrong}");
        }
        assert_eq!(whole::<u8>(1, u64::MAX)("0"), Err("expected a whole number from 1".to_owned()));
    }
}
