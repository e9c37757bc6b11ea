//! Turns the regulating screws of an instrument in SI units.

use super::placement::turned_by;
use super::{Curve, Instrument, ScrewAction};

impl Instrument {
    /// Returns the index of the screw called `name`.
    pub fn screw(&self, name: &str) -> Option<usize> {
        self.screws.iter().position(|screw| screw.name == name)
    }

    /// Turns screw number `screw` to `setting`, counted from the drawn geometry: in metres, in radians for a screw that
    /// turns a curve, in newton metres for a spring.
    ///
    /// Returns `false` and leaves the instrument unchanged if there is no such screw, if `setting` is not finite, or if
    /// it would cancel or reverse a spring's torque.
    #[must_use]
    pub fn turn(&mut self, screw: usize, setting: f64) -> bool {
        let Some(turned) = self.screws.get(screw) else {
            return false;
        };
        let action = turned.action.clone();
        if !setting.is_finite() || !self.shift(&action, setting - turned.setting) {
            return false;
        }
        self.fields.screws[screw].setting = setting;
        true
    }

    /// Changes the zone or spring on which a screw acts by `by` (m, rad or N m). Returns `false` and changes nothing if
    /// a spring's torque would be cancelled or reversed.
    pub(crate) fn shift(&mut self, action: &ScrewAction, by: f64) -> bool {
        let moved = |point: &mut [f64; 2], direction: [f64; 2]| {
            point[0] += by * direction[0];
            point[1] += by * direction[1];
        };
        match *action {
            ScrewAction::Disc { zone, direction } => moved(&mut self.fields.zones[zone].disc_center_m, direction),
            ScrewAction::Curve { zone, direction } => match &mut self.fields.zones[zone].curve {
                Curve::Line { point_m, .. } => moved(point_m, direction),
                Curve::Segment { from_m, to_m, .. } => {
                    moved(from_m, direction);
                    moved(to_m, direction);
                }
                Curve::Disc { center_m, .. } => moved(center_m, direction),
            },
            // The curve turns about a point of its own, so moving and turning it can be done in any order.
            ScrewAction::Turn { zone } => match &mut self.fields.zones[zone].curve {
                Curve::Line { normal, .. } => *normal = turned_by(*normal, by),
                Curve::Segment { from_m, to_m, .. } => {
                    let middle = [0.5 * (from_m[0] + to_m[0]), 0.5 * (from_m[1] + to_m[1])];
                    for end in [from_m, to_m] {
                        let [x, y] = turned_by([end[0] - middle[0], end[1] - middle[1]], by);
                        *end = [middle[0] + x, middle[1] + y];
                    }
                }
                Curve::Disc { .. } => {}
            },
            ScrewAction::Spring { spring } => {
                let torque = &mut self.fields.springs[spring].torque_n_m;
                let tightened = *torque + by * torque.signum();
                if by != 0.0 && tightened * *torque <= 0.0 {
                    return false;
                }
                *torque = tightened;
            }
        }
        true
    }
}
