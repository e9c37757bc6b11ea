//! One contact zone in one step: its compression and Jacobian row, (C1) of the book, felt force, and the error of its
//! linearisation.

use crate::compiled_zone::CompiledZone;
use crate::curvature::Margins;
use crate::felt::{Carried, Curvature, ONSET};
use crate::law::{MEMORY, Memory};
use crate::pose::Pose;
use crate::real::{Mask, Real};
use crate::support::Support;
use crate::surface::Yielding;
use crate::timing::Timing;
use crate::vector::{Vector, scale, sub};

/// N; a remainder that is not known, for no force comes near it.
const FAR_OFF: f64 = 1e30;

/// A row of as many entries as its zone's support has. It is not written out: rows of more than three entries are few.
pub(crate) const ANY_LENGTH: usize = 0;

/// Contact of one zone during one step.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    /// Compression g of the felt at the theta point, m; negative when the zone is open.
    pub compression: T,
    /// Compression rate dg/dt, m/s.
    pub rate: T,
    /// Outward unit normal of the curve, toward the disc, in the world.
    pub normal: Vector<T>,
    /// Contact point on the curve, m, in the world.
    pub point: Vector<T>,
    /// Normal force F, N, never negative; pushes the disc along `normal`.
    pub force: T,
    /// Part of `force` due to the felt's loss law, N: what remains of it when `force` is limited to at least 0.
    pub damping_force: T,
    /// Increase of the energy stored in the felt's internal state over the step, J; 0 for a felt without internal
    /// state. The loss is the work of `damping_force` less this.
    pub gained: T,
}

/// What the step keeps of a zone that it has looked at. The rest is worked out again for whoever asks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactState<T: Real, const B: usize> {
    /// Whether the zone is near enough to be touched during the step.
    pub in_reach: T::Mask,
    /// Normal force F, N, never negative.
    pub force: T,
    /// h dF/dv1 along the row (the linearised felt), never negative.
    pub tangent: T,
    /// Compression at the theta point, m, and dg/dt, m/s. The felt's curvature is worked out from them, where it is
    /// asked for.
    pub compression: T,
    pub rate: T,
    /// The felt's memory at the step's start, where it has one.
    pub memory: Memory<T>,
    /// Row G in relative velocities, for the zone's supporting joints: dg/dt = G w.
    pub row: [T; B],
}

/// Whether a zone touches in the step, and its compression.
pub(crate) struct Proximity<T: Real> {
    /// Whether it touches during the step.
    pub touched: T::Mask,
    pub compression: T,
    pub normal: Vector<T>,
}

impl<T: Real, const B: usize> ContactState<T, B> {
    pub(crate) fn apart() -> Self {
        let z = T::ZERO;
        ContactState {
            in_reach: T::Mask::splat(false),
            force: z,
            tangent: z,
            compression: z,
            rate: z,
            memory: [z; MEMORY],
            row: [z; B],
        }
    }

    /// Evaluates the geometry at the theta point, and in which lanes the felt is touched during the step. The row has K
    /// entries, or [`ANY_LENGTH`]. `candidates`: the lanes that may be in reach.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn evaluate<const K: usize, const YIELDS: bool>(
        &mut self,
        zone: &CompiledZone<T>,
        support: &Support<T, B>,
        pose: &Pose<T, B>,
        w: &[T; B],
        timing: &Timing<T>,
        candidates: T::Mask,
        surface: &Yielding<T>,
        margins: &mut Margins<T>,
    ) -> Proximity<T> {
        let center = zone.center(pose);
        let (mut compression, normal) = zone.compression_and_normal(pose, center);
        if const { YIELDS } {
            compression -= surface.offset;
        }
        let in_reach = candidates.and((-timing.reach).le(compression));
        self.in_reach = in_reach;
        if !in_reach.any() {
            return Proximity { touched: in_reach, compression, normal };
        }
        let mut rate = if const { K == ANY_LENGTH } {
            pose.turning_row(support, center, normal, &mut self.row);
            support.product(&self.row, w)
        } else {
            let mut row = support.entries::<K>(&self.row);
            for k in 0..K {
                row.entry[k] = support.sign(k) * pose.turning(row.joint[k], center, normal);
                self.row[k] = row.entry[k];
            }
            row.product(w)
        };
        if const { YIELDS } {
            rate -= surface.drift;
        }
        (self.compression, self.rate) = (compression, rate);
        // Where the mean is worked out from end to end, the ends say what is touched: sqrt(3) farther out than the
        // Gauss points.
        let seen = if const { YIELDS } { T::from_f64(1.732_050_807_568_877_2) * rate } else { rate };
        let touched = in_reach.and(T::from_f64(ONSET).lt(margins.include(compression, seen, timing)));
        Proximity { touched, compression, normal }
    }

    /// The felt's force and tangent, where it is touched.
    #[inline(always)]
    pub(crate) fn press(
        &mut self,
        zone: &CompiledZone<T>,
        timing: &Timing<T>,
        touched: T::Mask,
        surface: &Yielding<T>,
        margins: &mut Margins<T>,
    ) {
        if const { T::LANES == 1 } && zone.felt.yields() {
            return self.press_on(zone, timing, touched, surface, margins);
        }
        let pressed = zone.felt.press(self.compression, self.rate, timing, touched, &self.memory);
        margins.include_opening(pressed.opening, touched);
        self.force = pressed.force;
        self.tangent = pressed.tangent;
    }

    /// Evaluates the felt's force on a compliant surface. It writes the result here and returns nothing, so that the
    /// fast path keeps its own in registers.
    #[cold]
    #[inline(never)]
    fn press_on(
        &mut self,
        zone: &CompiledZone<T>,
        timing: &Timing<T>,
        touched: T::Mask,
        surface: &Yielding<T>,
        margins: &mut Margins<T>,
    ) {
        let carried = Carried { memory: &self.memory, surface };
        let pressed = zone.felt.press_yielding(self.compression, self.rate, timing, touched, carried);
        margins.include_opening(pressed.opening, touched);
        self.force = pressed.force;
        self.tangent = pressed.tangent;
    }

    /// The felt's force on a surface that yields, N, and -dF/d(rate), N s/m, where the rate is so much greater.
    pub(crate) fn pressed_at(
        &self,
        zone: &CompiledZone<T>,
        timing: &Timing<T>,
        more: T,
        surface: &Yielding<T>,
    ) -> [T; 2] {
        let (compression, rate) = (self.compression + timing.h_theta * more, self.rate + more);
        let carried = Carried { memory: &self.memory, surface };
        let pressed = zone.felt.press_yielding(compression, rate, timing, T::Mask::splat(true), carried);
        [pressed.force, pressed.tangent / timing.h_theta]
    }

    /// What a caller may read: the contact at the pose of the last evaluation, its force carried along with the last
    /// change of the relative velocities.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn contact(
        &self,
        zone: &CompiledZone<T>,
        support: &Support<T, B>,
        pose: &Pose<T, B>,
        change: &[T; B],
        timing: &Timing<T>,
        touched: T::Mask,
        surface: &Yielding<T>,
    ) -> Contact<T> {
        let (compression, normal) = zone.compression_and_normal(pose, zone.center(pose));
        let ahead = timing.theta * support.product(&self.row, change);
        let (rate, ahead_compression) = (self.rate + ahead, compression + timing.h_theta * ahead);
        let point = zone.contact_point(pose, compression, normal);
        if const { T::LANES == 1 } && zone.felt.yields() {
            return self.contact_that_yields(
                zone,
                [ahead_compression, rate],
                [normal, point],
                timing,
                touched,
                surface,
            );
        }
        let pressed = zone.felt.press(ahead_compression, rate, timing, touched, &self.memory);
        Contact {
            compression: ahead_compression,
            rate,
            normal,
            point,
            force: pressed.force,
            damping_force: pressed.damping_force,
            gained: zone.felt.gained(ahead_compression, rate, timing, touched, &self.memory),
        }
    }

    /// The same on a compliant surface, from compression and rate to where the surface was: it is displaced, and the
    /// felt is compressed by so much less.
    #[cold]
    #[inline(never)]
    fn contact_that_yields(
        &self,
        zone: &CompiledZone<T>,
        [compression, rate]: [T; 2],
        [normal, point]: [Vector<T>; 2],
        timing: &Timing<T>,
        touched: T::Mask,
        surface: &Yielding<T>,
    ) -> Contact<T> {
        let (before, carried) = (compression - surface.offset, Carried { memory: &self.memory, surface });
        let pressed = zone.felt.press_yielding(before, rate, timing, touched, carried);
        let (after, rate) = zone.felt.give_way(before, rate, timing, touched, carried);
        Contact {
            compression: after,
            rate,
            normal,
            point: sub(point, scale(normal, compression - after)),
            force: pressed.force,
            damping_force: pressed.damping_force,
            gained: zone.felt.gained(after, rate, timing, touched, &self.memory),
        }
    }

    /// The felt's memory at the step's end, for a felt that has one; `touched`: not in all lanes apart.
    #[inline(always)]
    pub(crate) fn remembered(
        &self,
        zone: &CompiledZone<T>,
        support: &Support<T, B>,
        change: &[T; B],
        timing: &Timing<T>,
        touched: T::Mask,
        surface: &Yielding<T>,
    ) -> Memory<T> {
        if !touched.any() {
            return zone.felt.relax(timing, &self.memory).0;
        }
        let ahead = timing.theta * support.product(&self.row, change);
        let (rate, compression) = (self.rate + ahead, self.compression + timing.h_theta * ahead);
        let (compression, rate) = if const { T::LANES == 1 } && zone.felt.yields() {
            zone.felt.give_way(compression, rate, timing, touched, Carried { memory: &self.memory, surface })
        } else {
            (compression, rate)
        };
        match zone.felt.load_state(compression, rate, timing, touched, &self.memory) {
            Some(memory) if touched.all() => memory,
            recalled => {
                let alone = zone.felt.relax(timing, &self.memory).0;
                let mut memory = recalled.unwrap_or(alone);
                for (kept, alone) in memory.iter_mut().zip(alone) {
                    *kept = T::select(touched, *kept, alone);
                }
                memory
            }
        }
    }

    /// How far the force may be from its linearisation after the relative velocities have changed by `change`, N: what
    /// one Newton iteration leaves to the next.
    #[inline(always)]
    pub(crate) fn remainder(
        &self,
        zone: &CompiledZone<T>,
        support: &Support<T, B>,
        change: &[T; B],
        timing: &Timing<T>,
        active: T::Mask,
        surface: &Yielding<T>,
    ) -> T {
        let rate = (timing.theta * support.product(&self.row, change)).abs();
        if const { T::LANES == 1 } && zone.felt.yields() {
            return self.remainder_on(zone, rate, timing, active, surface);
        }
        let bend = zone.felt.curvature(self.compression, self.rate, timing, active, &self.memory);
        self.bent(zone, &bend, rate, timing, active)
    }

    /// The same on a curve that yields.
    #[cold]
    #[inline(never)]
    fn remainder_on(
        &self,
        zone: &CompiledZone<T>,
        rate: T,
        timing: &Timing<T>,
        active: T::Mask,
        surface: &Yielding<T>,
    ) -> T {
        if surface.shared {
            return T::from_f64(FAR_OFF);
        }
        let carried = Carried { memory: &self.memory, surface };
        let bend = zone.felt.bend_yielding(self.compression, self.rate, timing, active, carried);
        self.bent(zone, &bend, rate, timing, active)
    }

    /// What a curvature makes of a change of the rate, N.
    #[inline(always)]
    fn bent(&self, zone: &CompiledZone<T>, bend: &Curvature<T>, rate: T, timing: &Timing<T>, active: T::Mask) -> T {
        // To second order; where the clamp at zero may have come or gone, to first.
        let (linear, quadratic) = (bend.linear * rate, bend.quadratic * rate * rate);
        let bent = T::select(linear.lt(bend.slack), quadratic, linear.max(quadratic));
        if active.all() {
            return bent;
        }
        // Not touched before: all of it.
        let reach = timing.h_theta + timing.node;
        let deepest = (self.compression + timing.node * self.rate.abs() + reach * rate).max(T::ZERO);
        let onset = zone.felt.largest_force(deepest, self.rate.abs() + rate);
        T::select(active, bent, T::only(self.in_reach, onset))
    }

    /// The row that maps relative velocities to the slip u = t . (v_disc - v_curve) at the contact point, in some
    /// lanes; t is the normal turned clockwise by a quarter turn.
    #[inline(always)]
    pub(crate) fn slip_row(
        proximity: &Proximity<T>,
        zone: &CompiledZone<T>,
        support: &Support<T, B>,
        pose: &Pose<T, B>,
        lanes: T::Mask,
        row: &mut [T; B],
    ) {
        let (before, point) = (*row, zone.contact_point(pose, proximity.compression, proximity.normal));
        pose.turning_row(support, point, [-proximity.normal[1], proximity.normal[0]], row);
        if !lanes.all() {
            for (k, _) in support.joints() {
                row[k] = T::select(lanes, row[k], before[k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Body, ContactCurve, Description, GROUND, Zone};
    use crate::felt::Felt;
    use crate::law::{Exponent, Loss};

    /// Rows against central differences of the compression, for every kind of curve, on a three-body chain: the claim
    /// is that dg/dt = G v is the exact derivative of g. Differences of step 1e-6 carry an error near 1e-9.
    #[test]
    fn rows_are_the_gradient_of_the_compression() {
        let body = |parent, pivot| Body { parent, pivot, mass: 1.0, ..Body::inert() };
        let bodies = [body(GROUND, [0.1, 0.2]), body(0, [0.5, -0.1]), body(1, [0.3, 0.2]), body(GROUND, [1.0, 1.0])];
        let felt = Felt { stiffness: 1.0, exponent: Exponent::Two, loss: Loss::quadratic(1.0) };
        let s = 0.5_f64.sqrt();
        let curves = [
            ContactCurve::Line { point: [0.1, 0.3], normal: [s, s] },
            ContactCurve::Segment { from: [0.0, 0.0], direction: [s, -s], length: 0.4, rounding: 0.05 },
            ContactCurve::Disc { center: [0.2, 0.1], radius: 0.1 },
        ];
        for curve in curves {
            for (a, b) in [(2, 3), (3, 2), (2, 0), (0, 2), (GROUND, 2), (2, GROUND)] {
                let zone =
                    Zone { disc_body: a, center: [0.2, -0.3], radius: 5.0, curve_body: b, curve, felt, friction: None };
                let description = Description { bodies: &bodies, zones: &[zone], ..Description::default() };
                let model = description.compile::<4, 1>().unwrap();
                let q = [0.3, -0.7, 1.9, 0.4];
                let compression = |q: &[f64; 4]| Pose::of(&model, q).compression(&model, 0);
                let (mut contact, timing) = (ContactState::apart(), Timing::new(1e-3, 0.5));
                let (pose, support, w) = (Pose::of(&model, &q), &model.supports[0], [0.0; 4]);
                let (zone, margins) = (&model.compiled[0], &mut Margins::new());
                assert!(
                    contact
                        .evaluate::<4, false>(zone, support, &pose, &w, &timing, true, &Yielding::still(), margins)
                        .touched
                );
                let row = pose.compression_row(&model, 0);
                for i in 0..4 {
                    let e = 1e-6;
                    let (mut up, mut down) = (q, q);
                    up[i] += e;
                    down[i] -= e;
                    let difference = (compression(&up) - compression(&down)) / (2.0 * e);
                    assert!((difference - row[i]).abs() < 1e-8, "{curve:?} {a} {b} {i}");
                }
            }
        }
    }

    /// What one Newton iteration leaves to the next, by its definition: bent by the felt's curvature to second order,
    /// or to first where the clamp may have come or gone; of a felt that was not touched, the largest force that it may
    /// have now.
    #[test]
    fn the_remainder_is_what_it_says() {
        let felt = Felt { stiffness: 4e7, exponent: Exponent::Two, loss: Loss::quadratic(8e7) };
        let curve = ContactCurve::Line { point: [0.0, -0.1], normal: [0.0, 1.0] };
        let zone =
            Zone { disc_body: 0, center: [0.4, 0.0], radius: 0.1, curve_body: GROUND, curve, felt, friction: None };
        let bodies = [Body { mass: 1.0, ..Body::inert() }];
        let description = Description { bodies: &bodies, zones: &[zone], ..Description::default() };
        let model = description.compile::<1, 1>().unwrap();
        let (compiled, support) = (&model.compiled[0], &model.supports[0]);
        for theta in [0.5, 0.8] {
            let timing = Timing::new(1e-3, theta);
            for (angle, w) in [(-2e-3, 0.0), (-2e-3, -1.0), (-1e-2, 0.5)] {
                let mut contact = ContactState::<f64, 1>::apart();
                let pose = Pose::of(&model, &[angle]);
                contact.evaluate::<1, false>(
                    compiled,
                    support,
                    &pose,
                    &[w],
                    &timing,
                    true,
                    &Yielding::still(),
                    &mut Margins::new(),
                );
                for change in [1e-3, -0.2, 3.0] {
                    let rate = theta * (contact.row[0] * change).abs();
                    let bend =
                        compiled.felt.curvature(contact.compression, contact.rate, &timing, true, &[0.0; MEMORY]);
                    let (linear, quadratic) = (bend.linear * rate, bend.quadratic * rate * rate);
                    let bent = if linear < bend.slack { quadratic } else { linear.max(quadratic) };
                    let reach = timing.h_theta + timing.node;
                    let deepest = (contact.compression + timing.node * contact.rate.abs() + reach * rate).max(0.0);
                    let onset = (felt.stiffness + 8e7 * (contact.rate.abs() + rate)) * deepest * deepest;
                    for (active, expected) in [(true, bent), (false, onset)] {
                        let found =
                            contact.remainder(compiled, support, &[change], &timing, active, &Yielding::still());
                        assert!(
                            (found - expected).abs() <= 1e-12 * expected,
                            "{theta} {angle} {w} {change}: {found} {expected}"
                        );
                    }
                }
            }
        }
    }
}
