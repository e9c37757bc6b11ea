//! Turning the regulating screws of an instrument that is already in SI units.

use super::{Curve, Instrument, ScrewAction};

impl Instrument {
    /// Index of the screw called `name`.
    pub fn screw(&self, name: &str) -> Option<usize> {
        self.screws.iter().position(|screw| screw.name == name)
    }

    /// Turns screw number `screw` to `setting`, counted from the drawn geometry: metres, or newton metres for a spring.
    ///
    /// Returns whether it could be done. It cannot when there is no such screw, when `setting` is not finite, or when it
    /// would turn a spring's torque around; the instrument is then unchanged.
    #[must_use]
    pub fn turn(&mut self, screw: usize, setting: f64) -> bool {
        let Some(turned) = self.screws.get(screw) else {
            return false;
        };
        let action = turned.action.clone();
        if !setting.is_finite() || !self.shift(&action, setting - turned.setting) {
            return false;
        }
        self.screws[screw].setting = setting;
        true
    }

    /// Moves what a screw moves by `by` (m or N m); `false`, and nothing moved, when a spring would change its side.
    pub(crate) fn shift(&mut self, action: &ScrewAction, by: f64) -> bool {
        let moved = |point: &mut [f64; 2], direction: [f64; 2]| {
            point[0] += by * direction[0];
            point[1] += by * direction[1];
        };
        match *action {
            ScrewAction::Disc { zone, direction } => moved(&mut self.zones[zone].disc_center_m, direction),
            ScrewAction::Curve { zone, direction } => match &mut self.zones[zone].curve {
                Curve::Line { point_m, .. } => moved(point_m, direction),
                Curve::Segment { from_m, to_m, .. } => {
                    moved(from_m, direction);
                    moved(to_m, direction);
                }
                Curve::Disc { center_m, .. } => moved(center_m, direction),
            },
            ScrewAction::Spring { spring } => {
                let torque = &mut self.springs[spring].torque_n_m;
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
