//! How long a hammer cannot meet its string, whatever it does.

use erard::instrument::Instrument;

/// A hammer away from its string: it has to turn by so much before it can touch.
///
/// The compression of a zone between the ground and a body that is hinged on the ground changes by at most the body's lever (the
/// distance between its pivot and the disc's centre) per radian. This is a bound and no estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    body: usize,
    from_rad: f64,
    least_rad: f64,
}

/// The body that meets the string, and its lever, m; `None` where the bound does not hold.
pub(super) fn lever(instrument: &Instrument) -> Option<(usize, f64)> {
    let zone = &instrument.zones[instrument.roles.string?];
    let [x, y] = zone.disc_center_m;
    let (body, lever_m) = match (zone.disc_body, zone.curve_body) {
        (Some(body), None) => (body, libm::hypot(x, y)),
        (None, Some(body)) => {
            let pivot = instrument.bodies[body].pivot_m;
            (body, libm::hypot(x - pivot[0], y - pivot[1]))
        }
        _ => return None,
    };
    (instrument.bodies[body].parent.is_none() && lever_m > 0.0).then_some((body, lever_m))
}

impl Reach {
    /// Of a hammer at these angles, its compression of the string `gap_m` (negative apart); `None` where it touches.
    pub fn of((body, lever_m): (usize, f64), angle: &[f64], gap_m: f64) -> Option<Self> {
        // The last thousandth is left to rounding.
        (gap_m < 0.0).then(|| Reach { body, from_rad: angle[body], least_rad: 0.999 * -gap_m / lever_m })
    }

    /// Whether it still cannot touch.
    pub fn is_out(&self, angle: &[f64]) -> bool {
        (angle[self.body] - self.from_rad).abs() < self.least_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The grand's hammer meets the string with a lever that is the length of its shank, and the bound holds where it is turned.
    #[test]
    fn the_grands_hammer() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let (body, lever_m) = lever(&grand).unwrap();
        assert_eq!(Some(body), grand.roles.hammer);
        assert!((0.1..0.2).contains(&lever_m), "{lever_m}");
        let mut angle = [0.0; 6];
        let reach = Reach::of((body, lever_m), &angle, -0.01).unwrap();
        angle[body] = 0.009 / lever_m;
        assert!(reach.is_out(&angle));
        angle[body] = -0.01 / lever_m;
        assert!(!reach.is_out(&angle));
        assert!(Reach::of((body, lever_m), &angle, 1e-5).is_none());
    }
}
