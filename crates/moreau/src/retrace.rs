//! Forces of a step that another program part, e.g. a lane, has computed.

use crate::curvature::Margins;
use crate::felt::ONSET;
use crate::forces::drive_force;
use crate::input::SiteInput;
use crate::laws::recall_memories;
use crate::model::Model;
use crate::real::Scalar;
use crate::settings::Settings;
use crate::state::State;
use crate::timing::Timing;
use crate::workspace::Workspace;

impl<T: Scalar, const B: usize, const Z: usize, const N: usize> Workspace<T, B, Z, N> {
    /// Evaluates the forces of a step from the states before and after it and its input, with all curves at their
    /// described places. Afterwards this workspace can be read as if it had taken the step, to the error of the step's
    /// Newton iteration; a [`crate::Ledger`] records it likewise. Nothing is solved, so N may be 0. Use a new
    /// workspace, or one that was only used for this function and this model.
    pub fn retrace(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        input: &SiteInput<T>,
        before: &State<T, B, Z>,
        after: &State<T, B, Z>,
    ) {
        self.contacts.touched_count = 0;
        let timing = Timing::new(settings.step, settings.theta);
        let kinematics = &mut self.kinematics;
        let mut angle = before.angle;
        for i in 0..B {
            let mean = before.velocity[i] + timing.theta * (after.velocity[i] - before.velocity[i]);
            kinematics.velocity[i] = mean;
            angle[i] += timing.h_theta * mean;
        }
        kinematics.joint_velocity = model.tree.relative(&kinematics.velocity);
        kinematics.pose.place(&model.tree, model.first_moments(), &angle);
        if model.remembers {
            recall_memories(model, before, self);
            for &z in model.dry_zones() {
                self.dry.force[z] = after.memory[z][0];
            }
        }
        self.retrace_drive(model, &timing, input, [before, after]);
        for z in 0..model.zone_count {
            self.retrace_zone(model, &timing, z);
        }
    }

    fn retrace_drive(
        &mut self,
        model: &Model<T, B, Z>,
        timing: &Timing<T>,
        input: &SiteInput<T>,
        [before, after]: [&State<T, B, Z>; 2],
    ) {
        let Workspace { kinematics, drive, .. } = self;
        let Some(site) = &model.site else { return };
        let x = kinematics.pose.point(site.body, site.point);
        kinematics.pose.turning_row(&model.site_support, x, site.direction, &mut drive.site_row);
        let driven = drive_force(model, input, &before.hand, timing, kinematics, drive);
        drive.force = match input {
            SiteInput::Rigid { .. } => after.rigid_force,
            _ => driven.map_or(T::ZERO, |(force, _)| force),
        };
    }

    fn retrace_zone(&mut self, model: &Model<T, B, Z>, timing: &Timing<T>, z: usize) {
        let Workspace { kinematics, contacts, .. } = self;
        let (zone, support, pose) = (&model.compiled[z], &model.supports[z], &kinematics.pose);
        let center = zone.center(pose);
        let (compression, normal) = zone.compression_and_normal(pose, center);
        let contact = &mut contacts.states[z];
        pose.turning_row(support, center, normal, &mut contact.row);
        let rate = support.product(&contact.row, &kinematics.joint_velocity);
        // The step's own test.
        if Margins::new().include(compression, rate, timing) <= T::from_f64(ONSET) {
            return;
        }
        (contact.in_reach, contact.compression, contact.rate) = (true, compression, rate);
        contacts.active[z] = true;
        contacts.touched[contacts.touched_count] = z;
        contacts.touched_count += 1;
        if zone.slides {
            let point = zone.contact_point(pose, compression, normal);
            pose.turning_row(support, point, [-normal[1], normal[0]], &mut contacts.slip_row[z]);
            contacts.has_slip_row[z] = true;
        }
    }
}
