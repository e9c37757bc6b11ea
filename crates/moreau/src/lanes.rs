//! Several mechanisms in the lanes of one model. The lanes may have another precision than the mechanisms, whose number
//! type is S.

use crate::compiled_zone::CompiledZone;
use crate::curvature::Curvatures;
use crate::description::{ContactCurve, Site, Zone};
use crate::felt::Felt;
use crate::model::{Dwelling, Model};
use crate::real::{Real, Scalar, cast, join, join_all};
use crate::settings::{FrictionLaw, Settings};
use crate::state::State;
use crate::support::Support;
use crate::tree::Tree;
use crate::vector::Vector;

impl<T: Real, const B: usize, const Z: usize> Model<T, B, Z> {
    /// Joins one model per lane (`T::LANES` of them). Returns `None` if their number differs from that, or if they
    /// differ in anything but numbers: parents, bodies of zones, kinds of curve and felt, or which parts have friction.
    pub fn of_lanes<S: Scalar>(models: &[&Model<S, B, Z>]) -> Option<Self> {
        let first = models.first()?;
        if models.len() != T::LANES || !models.iter().all(|m| alike(first, m)) {
            return None;
        }
        let numbers = |f: fn(&Model<S, B, Z>) -> [S; B]| join_all::<S, T, B>(|lane| f(models[lane]));
        let zones = core::array::from_fn(|z| zone_of_lanes(|lane| &models[lane].zones[z]));
        let moment: [Vector<T>; B] = core::array::from_fn(|i| join_all(|lane| models[lane].moment[i]));
        let mut joined = Model {
            tree: Tree::of_lanes(|lane| &models[lane].tree),
            dry: numbers(|m| m.dry),
            viscous: numbers(|m| m.viscous),
            spring_torque: numbers(|m| m.spring_torque),
            spring_stiffness: numbers(|m| m.spring_stiffness),
            inertia: numbers(|m| m.inertia),
            joint_inertia: numbers(|m| m.joint_inertia),
            moment,
            moment_x: numbers(|m| m.moment_x),
            moment_y: numbers(|m| m.moment_y),
            weight: numbers(|m| m.weight),
            centrifugal: numbers(|m| m.centrifugal),
            compiled: core::array::from_fn(|z| CompiledZone::of(&zones[z])),
            zones,
            supports: core::array::from_fn(|z| Support::of_lanes(|lane| &models[lane].supports[z])),
            excursions: [T::ZERO; Z],
            look: first.look,
            zone_count: first.zone_count,
            sliding_zones: first.sliding_zones,
            sliding_count: first.sliding_count,
            remembering: first.remembering,
            remembering_count: first.remembering_count,
            dry_felts: first.dry_felts,
            dry_count: first.dry_count,
            dwelling: Dwelling {
                pivot_gain: numbers(|m| m.dwelling.pivot_gain),
                pivot_rate: numbers(|m| m.dwelling.pivot_rate),
                zone_gain: join_all(|lane| models[lane].dwelling.zone_gain),
                zone_rate: join_all(|lane| models[lane].dwelling.zone_rate),
                count: models.iter().map(|model| model.dwelling.count).max().unwrap_or(0),
            },
            remembers: models.iter().any(|model| model.remembers),
            curvatures: Curvatures::of_lanes(|lane| &models[lane].curvatures),
            // The lanes may differ in which pivots have friction.
            laws: models.iter().map(|model| model.laws).max().unwrap_or(0),
            site: None,
            site_support: Support::of_lanes(|lane| &models[lane].site_support),
            gravity: join(|lane| models[lane].gravity),
        };
        if let Some(site) = &first.site {
            let numbers = |f: fn(&Site<S>) -> S| join(|lane| models[lane].site.as_ref().map_or(f(site), f));
            joined.site = Some(Site {
                body: site.body,
                point: [numbers(|s| s.point[0]), numbers(|s| s.point[1])],
                direction: [numbers(|s| s.direction[0]), numbers(|s| s.direction[1])],
                stiffness: numbers(|s| s.stiffness),
                damping: numbers(|s| s.damping),
            });
        }
        Some(joined)
    }
}

/// Whether two models differ in their numbers only.
fn alike<T: Real, const B: usize, const Z: usize>(a: &Model<T, B, Z>, b: &Model<T, B, Z>) -> bool {
    let site = |m: &Model<T, B, Z>| m.site.as_ref().map(|s| s.body);
    a.tree.parent == b.tree.parent
        && a.zone_count == b.zone_count
        && site(a) == site(b)
        // What moves the curve of a zone that yields knows nothing of lanes.
        && (0..a.zone_count).all(|z| !a.yields(z) && !b.yields(z))
        && a.zones.iter().zip(&b.zones).all(|(a, b)| {
            use core::mem::discriminant;
            (a.disc_body, a.curve_body, a.friction.is_some()) == (b.disc_body, b.curve_body, b.friction.is_some())
                && discriminant(&a.curve) == discriminant(&b.curve)
                && a.felt.kind() == b.felt.kind()
        })
}

/// The zones of all lanes; their kinds are the first one's.
fn zone_of_lanes<'a, S: Scalar + 'a, T: Real>(zone: impl Fn(usize) -> &'a Zone<S>) -> Zone<T> {
    let first = zone(0);
    // Numbers of a curve in a fixed order, whatever its kind.
    let numbers = |lane: usize| match zone(lane).curve {
        ContactCurve::Line { point, normal } => [point[0], point[1], normal[0], normal[1], S::ZERO, S::ZERO],
        ContactCurve::Segment { from, direction, length, rounding } => {
            [from[0], from[1], direction[0], direction[1], length, rounding]
        }
        ContactCurve::Disc { center, radius } => [center[0], center[1], radius, S::ZERO, S::ZERO, S::ZERO],
    };
    let [a, b, c, d, e, f]: [T; 6] = join_all(numbers);
    let curve = match first.curve {
        ContactCurve::Line { .. } => ContactCurve::Line { point: [a, b], normal: [c, d] },
        ContactCurve::Segment { .. } => {
            ContactCurve::Segment { from: [a, b], direction: [c, d], length: e, rounding: f }
        }
        ContactCurve::Disc { .. } => ContactCurve::Disc { center: [a, b], radius: c },
    };
    Zone {
        disc_body: first.disc_body,
        center: join_all(|lane| zone(lane).center),
        radius: join(|lane| zone(lane).radius),
        curve_body: first.curve_body,
        curve,
        felt: Felt::of_lanes(|lane| zone(lane).felt),
        friction: first.friction.map(|mu| join(|lane| zone(lane).friction.unwrap_or(mu))),
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// Joins one state per lane.
    ///
    /// # Panics
    /// Panics if there are fewer states than lanes.
    pub fn of_lanes<S: Scalar>(states: &[&State<S, B, Z>]) -> Self {
        let mut joined = State::at_rest([T::ZERO; B]);
        for lane in 0..T::LANES {
            joined.set_lane(lane, states[lane]);
        }
        joined
    }

    /// Sets one lane's state.
    pub fn set_lane<S: Scalar>(&mut self, lane: usize, one: &State<S, B, Z>) {
        *self = State::from(self.numbers.zip(&one.numbers, |all, x| all.with_lane(lane, cast(x))));
    }

    /// Returns the state of one lane.
    pub fn lane<S: Scalar>(&self, lane: usize) -> State<S, B, Z> {
        State::from(self.numbers.lane_in(lane))
    }

    /// Copies the numbers of one lane into an existing state.
    pub fn copy_lane<S: Scalar>(&self, lane: usize, one: &mut State<S, B, Z>) {
        one.numbers = self.numbers.lane_in(lane);
    }
}

impl<T: Real> Settings<T> {
    /// Copies one mechanism's settings to all lanes. In single precision no tolerance is smaller than its rounding
    /// allows.
    pub fn in_lanes(one: &Settings<f64>) -> Self {
        use FrictionLaw::{Regularised, SetValued};
        let c = T::from_f64;
        let single = f64::EPSILON < T::Lane::EPSILON.to_f64();
        let at_least = |ulps: f64, x: f64| if single { c(x).max(c(ulps) * T::EPSILON) } else { c(x) };
        Settings {
            step: c(one.step),
            theta: c(one.theta),
            tolerance: at_least(64.0, one.tolerance),
            newton_limit: one.newton_limit,
            solver_tolerance: at_least(8.0, one.solver_tolerance),
            solver_limit: one.solver_limit,
            solver: one.solver,
            friction: match one.friction {
                SetValued => SetValued,
                Regularised { pivot_width, sliding_width } => {
                    Regularised { pivot_width: c(pivot_width), sliding_width: c(sliding_width) }
                }
            },
        }
    }
}
