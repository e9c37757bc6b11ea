//! The inside of the action, which `erard press` shows on request: pin reactions and accelerations, and where
//! the energy goes.

mod figure;
mod losses;

pub(crate) use figure::{losses_picture, reactions_picture};
pub(crate) use losses::LossReport;

use erard::player::PinSeries;

/// Name and values of the columns of pins and accelerations.
pub(crate) fn columns(pins: &[PinSeries]) -> Vec<(String, &[f64])> {
    let of = |pin: &'_ PinSeries| {
        [
            (format!("{}_rad_per_s2", pin.name), 0_usize),
            (format!("{}_pin_x_N", pin.name), 1),
            (format!("{}_pin_y_N", pin.name), 2),
        ]
    };
    pins.iter()
        .flat_map(|pin| {
            let values = [&pin.acceleration_rad_per_s2[..], &pin.pin_x_n, &pin.pin_y_n];
            of(pin).map(|(name, which)| (name, values[which]))
        })
        .collect()
}
