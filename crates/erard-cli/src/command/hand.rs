//! The hand between stroke and key, as options.

use clap::Args;
use erard::player::Hand;

use crate::failure::Failure;

/// A hand that plays the stroke.
#[derive(Debug, Args)]
pub(crate) struct HandOptions {
    /// Let a hand play the stroke, of so many grams at the fingertip: the stroke's force is its muscle's, or its muscle
    /// follows the stroke's motion; the force at the key is then the fingertip's [default: 200]
    #[arg(long, value_name = "GRAMS", num_args = 0..=1, require_equals = true, default_missing_value = "200")]
    hand: Option<f64>,
    /// How fast the hand arrives at the key, m/s: 0 presses, more strikes
    #[arg(long, value_name = "M/S", requires = "hand", default_value_t = 0.0, allow_negative_numbers = true)]
    hand_speed: f64,
}

impl HandOptions {
    /// The hand that was asked for.
    pub(crate) fn hand(&self) -> Result<Option<Hand>, Failure> {
        let Some(grams) = self.hand else { return Ok(None) };
        let hand = Hand { mass_kg: grams * 1e-3, start_m_s: self.hand_speed, ..Hand::default() };
        hand.check().map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Some(hand))
    }
}
