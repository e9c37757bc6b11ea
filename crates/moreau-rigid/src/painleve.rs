//! Where Coulomb's law admits no finite force.

use super::mixed::{Law, Mode, Problem};
use super::model::Model;
use moreau::Scalar;

/// Mobilities below this part of the contact's own are none: other laws hold the contact, which is not its friction's
/// doing.
const HELD: f64 = 1e-11;

/// Whether a contact was kept closed where no finite force can do that. While it slips u_n' = b + A f_n, b what
/// everything else does to it and A its mobility under full friction. With A < 0 and b < 0 no force f_n >= 0 keeps u_n
/// at zero, and none lets it part (Genot and Brogliato 1999: the inconsistent mode). Nothing may have collided in the
/// step: impulses of collisions are no finite forces, wherever they go.
#[allow(clippy::too_many_arguments)]
pub(super) fn jammed<T: Scalar, const N: usize>(
    model: &Model<'_, T>,
    slip: &[T; N],
    closing: &[T; N],
    mode: &[Mode; N],
    p: &[T; N],
    still: T,
    tolerance: T,
    problem: &Problem<T, N>,
) -> bool {
    if closing.iter().any(|u| *u > still) {
        return false;
    }
    (0..model.points()).any(|c| {
        let [n, t] = model.contact_laws(c);
        match problem.law[t] {
            Law::Coulomb(_, mu) if slip[t].abs() > still && p[n] > T::ZERO => {
                let factor = if slip[t] > T::ZERO { -mu } else { mu };
                let none = problem.delassus[n][n] * T::from_f64(HELD).max(T::EPSILON * T::from_f64(64.0));
                let (mobility, without) = problem.slipping_mobility(n, t, factor, mode, tolerance);
                mobility < -none && without < -tolerance
            }
            _ => false,
        }
    })
}
