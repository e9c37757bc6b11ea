//! Numbers as options: each says in its message what it expects.

use erard::parameter::{NumberError, Quantity, list_items};

/// A number of a quantity in its unit `unit`, which is also that of a number typed without one, from `least` to `most`
/// of these units.
pub(crate) fn between(
    quantity: Quantity,
    unit: &'static str,
    least: f64,
    most: f64,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match quantity.read_in(text, unit) {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) | Err(NumberError::Text { .. }) => {
            let blank = if unit.is_empty() { "" } else { " " };
            Err(format!("expected {} from {least} to {most}{blank}{unit}", quantity.name()))
        }
        Err(error) => Err(error.to_string()),
    }
}

/// Values of a list, in the unit of its option.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Values(pub(crate) Vec<f64>);

/// A list of values that `one` reads. A decimal comma is read between semicolons only.
pub(crate) fn list(
    one: impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<Values, String> + Clone + Send + Sync + 'static {
    move |text| {
        let items = list_items(text).map_err(|error| error.to_string())?;
        items.into_iter().map(&one).collect::<Result<_, _>>().map(Values)
    }
}

/// A number of a quantity in its unit `unit`, as [`between`]; whoever uses it checks its range.
pub(crate) fn number(
    quantity: Quantity,
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| quantity.read_in(text, unit).map_err(|error| error.to_string())
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
    use super::{Values, between, list, number, whole};
    use erard::parameter::Quantity;

    #[test]
    fn a_unit_may_follow_a_number() {
        let newtons = number(Quantity::Force, "N");
        assert_eq!(
            [newtons("5"), newtons("5N"), newtons("2.5 N"), newtons("5,5")],
            [Ok(5.0), Ok(5.0), Ok(2.5), Ok(5.5)]
        );
        assert!((newtons("500gf").unwrap() - 4.903_325).abs() < 1e-12);
        assert!(newtons("5mm").unwrap_err().contains("`mm` is not one of its units; expected N, mN"));
    }

    #[test]
    fn a_number_outside_its_range_is_refused_with_the_range() {
        let mm = between(Quantity::Length, "mm", 0.5, 100.0);
        assert_eq!([mm("10"), mm("1cm"), mm("0.5mm")], [Ok(10.0), Ok(10.0), Ok(0.5)]);
        for wrong in ["0.4", "1m", "-3"] {
            assert_eq!(mm(wrong), Err("expected a length from 0.5 to 100 mm".to_owned()), "{wrong}");
        }
    }

    #[test]
    fn a_decimal_comma_in_a_list_is_refused_with_the_semicolon() {
        let hertz = list(between(Quantity::Frequency, "Hz", 20.0, 20_000.0));
        for (text, read) in [
            ("1000", vec![1000.0]),
            ("1000, 2kHz", vec![1000.0, 2000.0]),
            ("1000Hz,2kHz", vec![1000.0, 2000.0]),
            ("62,5;1000", vec![62.5, 1000.0]),
        ] {
            assert_eq!(hertz(text), Ok(Values(read)), "{text}");
        }
        let comma = hertz("62,5Hz,1000Hz").unwrap_err();
        assert!(comma.contains("type `62.5Hz, 1000Hz` or `62,5Hz; 1000Hz`"), "{comma}");
        assert_eq!(hertz("1000,5"), Err("expected a frequency from 20 to 20000 Hz".to_owned()));
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
