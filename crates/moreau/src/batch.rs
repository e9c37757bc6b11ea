//! Several mechanisms in the lanes of one model. The lanes may be of another precision than the mechanisms: S is theirs.

use crate::ease::Bending;
use crate::form::Form;
use crate::joints::Parent;
use crate::model::{Curve, Exponent, Felt, Model, Site, Zone};
use crate::path::Path;
use crate::state::{Input, State};
use crate::survey::Survey;
use crate::vector::Vector;
use crate::{Real, Scalar, Settings};

/// A number in the lanes' precision.
#[inline(always)]
fn cast<S: Scalar, L: Scalar>(x: S) -> L {
    L::from_f64(x.to_f64())
}

#[inline(always)]
pub(crate) fn join<S: Scalar, T: Real>(x: impl Fn(usize) -> S) -> T {
    T::join(|lane| cast(x(lane)))
}

#[inline(always)]
pub(crate) fn join_all<S: Scalar, T: Real, const K: usize>(x: impl Fn(usize) -> [S; K]) -> [T; K] {
    core::array::from_fn(|k| join(|lane| x(lane)[k]))
}

impl<T: Real, const B: usize, const Z: usize> Model<T, B, Z> {
    /// As many models as there are lanes (`T::LANES`), side by side; `None` if their number is another, or if they differ in more than
    /// their numbers: in what is hinged on what, in the zones' bodies, kinds of curve, exponents, or in where there is friction.
    pub fn of_lanes<S: Scalar>(models: &[&Model<S, B, Z>]) -> Option<Self> {
        let first = models.first()?;
        if models.len() != T::LANES || !models.iter().all(|m| alike(first, m)) {
            return None;
        }
        let numbers = |f: fn(&Model<S, B, Z>) -> [S; B]| join_all::<S, T, B>(|lane| f(models[lane]));
        let o: [Vector<T>; B] = [[T::ZERO; 2]; B];
        let mut joined = Model {
            parent: first.parent,
            hinged: first.hinged,
            hinged_count: first.hinged_count,
            parents: [Parent { body: 0, children: [T::ZERO; B], own: [T::ZERO; B] }; B],
            parent_count: first.parent_count,
            deep: first.deep,
            pivot: o,
            link: [numbers(|m| m.link[0]), numbers(|m| m.link[1])],
            root: [numbers(|m| m.root[0]), numbers(|m| m.root[1])],
            dry: numbers(|m| m.dry),
            viscous: numbers(|m| m.viscous),
            spring_torque: numbers(|m| m.spring_torque),
            spring_stiffness: numbers(|m| m.spring_stiffness),
            inertia: numbers(|m| m.inertia),
            joint_inertia: numbers(|m| m.joint_inertia),
            moment: o,
            moment_x: numbers(|m| m.moment_x),
            moment_y: numbers(|m| m.moment_y),
            weight: numbers(|m| m.weight),
            whirl: numbers(|m| m.whirl),
            zones: core::array::from_fn(|z| zone_of_lanes(|lane| &models[lane].zones[z])),
            forms: core::array::from_fn(|z| Form::of(&zone_of_lanes(|lane| &models[lane].zones[z]))),
            paths: core::array::from_fn(|z| Path::of_lanes(|lane| &models[lane].paths[z])),
            bending: Bending::of_lanes(|lane| &models[lane].bending),
            site_path: Path::of_lanes(|lane| &models[lane].site_path),
            zone_count: first.zone_count,
            sliding_zones: first.sliding_zones,
            sliding_count: first.sliding_count,
            site: None,
            gravity: join(|lane| models[lane].gravity),
        };
        for i in 0..B {
            joined.pivot[i] = join_all(|lane| models[lane].pivot[i]);
            joined.moment[i] = join_all(|lane| models[lane].moment[i]);
            let parents = |lane: usize| &models[lane].parents[i];
            joined.parents[i] = Parent {
                body: first.parents[i].body,
                children: join_all(|lane| parents(lane).children),
                own: join_all(|lane| parents(lane).own),
            };
        }
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
    a.parent == b.parent
        && a.zone_count == b.zone_count
        && site(a) == site(b)
        && a.zones.iter().zip(&b.zones).all(|(a, b)| {
            use core::mem::discriminant as kind;
            (a.disc_body, a.curve_body, a.friction.is_some()) == (b.disc_body, b.curve_body, b.friction.is_some())
                && kind(&a.curve) == kind(&b.curve)
                && kind(&a.felt.exponent) == kind(&b.felt.exponent)
        })
}

/// The zones of all lanes; their kinds are the first one's.
fn zone_of_lanes<'a, S: Scalar + 'a, T: Real>(zone: impl Fn(usize) -> &'a Zone<S>) -> Zone<T> {
    let first = zone(0);
    // Numbers of a curve in a fixed order, whatever its kind.
    let numbers = |lane: usize| match zone(lane).curve {
        Curve::Line { point, normal } => [point[0], point[1], normal[0], normal[1], S::ZERO, S::ZERO],
        Curve::Segment { from, direction, length, rounding } => {
            [from[0], from[1], direction[0], direction[1], length, rounding]
        }
        Curve::Disc { center, radius } => [center[0], center[1], radius, S::ZERO, S::ZERO, S::ZERO],
    };
    let [a, b, c, d, e, f]: [T; 6] = join_all(numbers);
    let curve = match first.curve {
        Curve::Line { .. } => Curve::Line { point: [a, b], normal: [c, d] },
        Curve::Segment { .. } => Curve::Segment { from: [a, b], direction: [c, d], length: e, rounding: f },
        Curve::Disc { .. } => Curve::Disc { center: [a, b], radius: c },
    };
    let exponent = match first.felt.exponent {
        Exponent::Two => Exponent::Two,
        Exponent::TwoAndHalf => Exponent::TwoAndHalf,
        Exponent::Three => Exponent::Three,
        Exponent::Other(r) => Exponent::Other(join(|lane| match zone(lane).felt.exponent {
            Exponent::Other(r) => r,
            _ => r,
        })),
    };
    Zone {
        disc_body: first.disc_body,
        center: join_all(|lane| zone(lane).center),
        radius: join(|lane| zone(lane).radius),
        curve_body: first.curve_body,
        curve,
        felt: Felt {
            stiffness: join(|lane| zone(lane).felt.stiffness),
            exponent,
            damping: join(|lane| zone(lane).felt.damping),
        },
        friction: first.friction.map(|mu| join(|lane| zone(lane).friction.unwrap_or(mu))),
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// As many states as there are lanes, side by side.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn of_lanes<S: Scalar>(states: &[&State<S, B, Z>]) -> Self {
        let mut joined = State::at_rest(join_all(|lane| states[lane].angle));
        joined.velocity = join_all(|lane| states[lane].velocity);
        joined.trend = join_all(|lane| states[lane].trend);
        joined.pivot_friction = join_all(|lane| states[lane].pivot_friction);
        joined.tangential = join_all(|lane| states[lane].tangential);
        joined.side = join_all(|lane| states[lane].side);
        joined.rigid_force = join(|lane| states[lane].rigid_force);
        joined
    }

    /// Sets one lane's state.
    pub fn set_lane<S: Scalar>(&mut self, lane: usize, one: &State<S, B, Z>) {
        fn set<S: Scalar, T: Real, const K: usize>(all: &mut [T; K], lane: usize, one: &[S; K]) {
            for k in 0..K {
                all[k] = all[k].with_lane(lane, cast(one[k]));
            }
        }
        set(&mut self.angle, lane, &one.angle);
        set(&mut self.velocity, lane, &one.velocity);
        set(&mut self.trend, lane, &one.trend);
        set(&mut self.pivot_friction, lane, &one.pivot_friction);
        set(&mut self.tangential, lane, &one.tangential);
        set(&mut self.side, lane, &one.side);
        self.rigid_force = self.rigid_force.with_lane(lane, cast(one.rigid_force));
        self.survey = Survey::none();
    }

    /// One lane's state.
    pub fn lane<S: Scalar>(&self, lane: usize) -> State<S, B, Z> {
        fn of<S: Scalar, T: Real, const K: usize>(all: &[T; K], lane: usize) -> [S; K] {
            all.map(|x| cast(x.lane(lane)))
        }
        let mut one = State::at_rest(of(&self.angle, lane));
        one.velocity = of(&self.velocity, lane);
        one.trend = of(&self.trend, lane);
        one.pivot_friction = of(&self.pivot_friction, lane);
        one.tangential = of(&self.tangential, lane);
        one.side = of(&self.side, lane);
        one.rigid_force = cast(self.rigid_force.lane(lane));
        one
    }
}

/// The numbers of an input of one kind.
type Numbers<T> = fn(&Input<T>) -> Option<[T; 2]>;

impl<T: Real> Input<T> {
    /// One input per lane; `None` where they are not of one kind.
    #[inline(always)]
    pub fn of_lanes<S: Scalar>(inputs: &[Input<S>]) -> Option<Self> {
        let pair = |f: Numbers<S>| {
            let all = inputs.len() == T::LANES && inputs.iter().all(|i| f(i).is_some());
            all.then(|| join_all::<S, T, 2>(|lane| f(&inputs[lane]).unwrap_or([S::ZERO; 2])))
        };
        match inputs.first()? {
            Input::Free => inputs.iter().all(|i| matches!(i, Input::Free)).then_some(Input::Free),
            Input::Force(_) => {
                pair(|i| if let Input::Force(f) = i { Some([*f, S::ZERO]) } else { None }).map(|[f, _]| Input::Force(f))
            }
            Input::Motion { .. } => pair(|i| match i {
                Input::Motion { position, velocity } => Some([*position, *velocity]),
                _ => None,
            })
            .map(|[position, velocity]| Input::Motion { position, velocity }),
            Input::Rigid { .. } => {
                pair(|i| if let Input::Rigid { velocity } = i { Some([*velocity, S::ZERO]) } else { None })
                    .map(|[velocity, _]| Input::Rigid { velocity })
            }
        }
    }
}

impl<T: Real> Settings<T> {
    /// The same settings in every lane; in single precision, tolerances no tighter than its rounding allows.
    pub fn in_lanes(one: &Settings<f64>) -> Self {
        use crate::FrictionLaw::{Regularised, SetValued};
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
