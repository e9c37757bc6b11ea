//! All contact zones of a step.

use crate::Scalar;
use crate::model::Model;
use crate::settings::Settings;
use crate::state::Scratch;

/// Geometry and felt of every zone during the step; slip rows once, where a zone with friction first touches.
#[inline(always)]
pub(crate) fn evaluate_zones<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    again: bool,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { pose, contacts, slip_row, has_slip_row, velocity, .. } = scratch;
    pose.move_pivots(model, velocity);
    for (z, zone) in model.zones[..model.zone_count].iter().enumerate() {
        let contact = &mut contacts[z];
        // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
        if again && contact.out_of_reach {
            continue;
        }
        contact.evaluate(model, zone, pose, velocity, settings.step, settings.theta);
        if contact.active && zone.friction.is_some() && !has_slip_row[z] {
            slip_row[z] = contact.slip_row(model, zone, pose);
            has_slip_row[z] = true;
        }
    }
}
