//! Conditions under which a key was weighed: place of the weights, tapping, dampers, stack.

use erard::keyboard::is_sharp;

use super::equation::WeightFault;

/// Distance of the weights from the key's front edge, mm, unless it is given: half an inch, a sharp's from its own
/// edge. An estimate of the trade's measuring point.
pub(crate) const USUAL_PLACE_MM: f64 = 13.0;
/// Distance of that place from the balance pin, mm, of naturals and of sharps: 230 to 270 mm on full-size grands, and
/// 50 mm less. Within 20 mm it changes a correction of 13 mm by 0.2 g of 50.
const ARM_MM: [f64; 2] = [250.0, 200.0];
/// Possible distances from the front edge, mm.
pub(crate) const PLACES_MM: [f64; 2] = [0.0, 60.0];

/// Starting friction in weights of a key that was not tapped, g of friction weight: an estimate.
pub(crate) const UNTAPPED_G: f64 = 2.0;

/// Conditions of a weighing; `None` where nothing was said.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Conditions {
    /// Distance of the weights from the key's front edge, mm.
    pub measured_at_mm: Option<f64>,
    /// Whether the key was tapped, so that it did not stick.
    pub tapped: Option<bool>,
    /// Whether the dampers were lifted.
    pub dampers_lifted: Option<bool>,
    /// Whether the stack was on the keys.
    pub stack_on: Option<bool>,
}

impl Conditions {
    /// Weight at the usual place that is in balance with 1 g at the place where it was taken: the ratio of their arms.
    #[must_use]
    pub(crate) fn factor(&self, key: usize) -> f64 {
        let arm_mm = ARM_MM[usize::from(is_sharp(key))];
        self.measured_at_mm.map_or(1.0, |at_mm| 1.0 + (USUAL_PLACE_MM - at_mm) / arm_mm)
    }

    /// Whether starting friction is in the weights.
    #[must_use]
    pub(crate) fn is_untapped(&self) -> bool {
        self.tapped == Some(false)
    }

    /// Refuses weights with the dampers on the strings.
    ///
    /// # Errors
    /// The damper is in such weights, and nobody weighed it.
    pub(crate) fn check_dampers(&self) -> Result<(), WeightFault> {
        if self.dampers_lifted != Some(false) {
            return Ok(());
        }
        Err(WeightFault {
            name: "dampers_lifted",
            what: "down-weight or up-weight with the dampers on the strings".to_owned(),
            expected: "weights with the pedal down: a damper is in these, and in no usual range".to_owned(),
        })
    }
}

/// Reads an answer to a question about conditions.
#[must_use]
pub(crate) fn yes_or_no(text: &str) -> Option<bool> {
    match text.trim().to_lowercase().as_str() {
        "yes" | "y" | "true" | "on" | "lifted" => Some(true),
        "no" | "n" | "false" | "off" | "down" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published: one key has a key ratio of 0.51 from the front rail's bushing and 0.48 from the measuring point (T.
    /// Farrell, Pianotech list, 18 July 2006), so that the bushing lies 0.48 / 0.51 as far from the balance pin: 14.7
    /// mm of 250 behind the point, 28 mm behind the front edge.
    #[test]
    fn the_place_of_the_weights() {
        let at = |at_mm: f64| Conditions { measured_at_mm: Some(at_mm), ..Conditions::default() };
        assert_eq!([Conditions::default().factor(40), at(USUAL_PLACE_MM).factor(41)], [1.0; 2]);
        assert!((0.51 * at(27.7).factor(40) - 0.48).abs() < 0.001, "{}", at(27.7).factor(40));
        // At the edge the arm is longer: more of a weight counts, and more on a sharp, which is shorter.
        assert!(at(0.0).factor(40) > 1.05 && at(0.0).factor(41) > at(0.0).factor(40));
        assert_eq!((yes_or_no(" Lifted"), yes_or_no("off"), yes_or_no("2")), (Some(true), Some(false), None));
    }
}
