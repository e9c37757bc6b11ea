//! Owned description of a mechanism, in lists of any length.

use moreau::{Body, ContactCurve, Description, Dwell, Felt, Model, ModelError, Scalar, Site, Spring, Yields, Zone};

/// Parts of a mechanism, before compilation into a model of fixed size. Indices count from 0; the ground is
/// [`moreau::GROUND`].
#[derive(Debug, Clone)]
pub struct OwnedDescription<T = f64> {
    /// Bodies. A parent precedes its children.
    pub bodies: Vec<Body<T>>,
    /// Torsion springs at pivots.
    pub springs: Vec<Spring<T>>,
    /// Contact zones.
    pub zones: Vec<Zone<T>>,
    /// Pivots and zones whose dry friction grows while it sticks.
    pub dwells: Vec<Dwell<T>>,
    /// Zones whose curves belong to compliant subsystems.
    pub yields: Vec<Yields<T>>,
    /// Driven point; `None` if nothing drives the mechanism.
    pub site: Option<Site<T>>,
    /// Acceleration of gravity, m/s2, downward.
    pub gravity: T,
    /// Absolute angles at the start, rad, one per body.
    pub angles: Vec<T>,
}

impl<T: Scalar> OwnedDescription<T> {
    /// Borrows this description as the engine's [`Description`].
    pub fn borrowed(&self) -> Description<'_, T> {
        let OwnedDescription { bodies, springs, zones, dwells, yields, site, gravity, .. } = self;
        Description { bodies, springs, zones, dwells, yields, site: *site, gravity: *gravity }
    }

    /// Compiles the model in a given size.
    ///
    /// # Errors
    /// Returns [`ModelError`] if the mechanism does not fit or a number is out of its range.
    pub fn model<const B: usize, const Z: usize>(&self) -> Result<Model<T, B, Z>, ModelError> {
        self.borrowed().compile()
    }

    /// Returns the absolute angles at the start in a given size, rad; zero for unused places.
    pub fn first_angles<const B: usize>(&self) -> [T; B] {
        core::array::from_fn(|i| self.angles.get(i).copied().unwrap_or(T::ZERO))
    }
}

impl OwnedDescription<f64> {
    /// Returns all numbers of the description, in a fixed order.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.map(&mut |x| {
            numbers.push(x);
            x
        });
        numbers
    }

    /// The same mechanism with other numbers, of another type, in the same order; what lacks at the end is zero.
    pub(crate) fn with_numbers<T: Scalar>(&self, numbers: impl IntoIterator<Item = T>) -> OwnedDescription<T> {
        let mut numbers = numbers.into_iter();
        self.map(&mut |_| numbers.next().unwrap_or(T::ZERO))
    }

    /// Every number through a function, which is called in a fixed order.
    fn map<T: Scalar>(&self, f: &mut dyn FnMut(f64) -> T) -> OwnedDescription<T> {
        let bodies = self.bodies.iter().map(|b| Body {
            parent: b.parent,
            pivot: b.pivot.map(&mut *f),
            mass: f(b.mass),
            inertia: f(b.inertia),
            center_of_mass: b.center_of_mass.map(&mut *f),
            dry: f(b.dry),
            viscous: f(b.viscous),
        });
        let bodies = bodies.collect();
        let springs = self.springs.iter().map(|s| Spring {
            body: s.body,
            torque: f(s.torque),
            stiffness: f(s.stiffness),
            reference: f(s.reference),
        });
        let springs = springs.collect();
        let zones = self.zones.iter().map(|z| Zone {
            disc_body: z.disc_body,
            center: z.center.map(&mut *f),
            radius: f(z.radius),
            curve_body: z.curve_body,
            curve: match z.curve {
                ContactCurve::Line { point, normal } => {
                    ContactCurve::Line { point: point.map(&mut *f), normal: normal.map(&mut *f) }
                }
                ContactCurve::Segment { from, direction, length, rounding } => ContactCurve::Segment {
                    from: from.map(&mut *f),
                    direction: direction.map(&mut *f),
                    length: f(length),
                    rounding: f(rounding),
                },
                ContactCurve::Disc { center, radius } => {
                    ContactCurve::Disc { center: center.map(&mut *f), radius: f(radius) }
                }
            },
            felt: felt(&z.felt, f),
            friction: z.friction.map(&mut *f),
        });
        let zones = zones.collect();
        let dwells = self.dwells.iter().map(|d| Dwell { part: d.part, ratio: f(d.ratio), time: f(d.time) }).collect();
        let yields = self.yields.iter().map(|y| Yields { zone: y.zone, excursion: f(y.excursion) }).collect();
        let site = self.site.map(|s| Site {
            body: s.body,
            point: s.point.map(&mut *f),
            direction: s.direction.map(&mut *f),
            stiffness: f(s.stiffness),
            damping: f(s.damping),
        });
        let gravity = f(self.gravity);
        let angles = self.angles.iter().map(|x| f(*x)).collect();
        OwnedDescription { bodies, springs, zones, dwells, yields, site, gravity, angles }
    }
}

fn felt<T: Scalar>(felt: &Felt<f64>, f: &mut dyn FnMut(f64) -> T) -> Felt<T> {
    Felt { stiffness: f(felt.stiffness), exponent: felt.exponent.map(&mut *f), loss: felt.loss.map(f) }
}

/// Point and zone observed after every step, besides the driven point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Probes {
    /// Probe point: a body and a point, m, in the body's frame (an action's hammer).
    pub point: Option<(usize, [f64; 2])>,
    /// Zone that the probe point hits (an action's string). Instant and speed are extrapolated from the motion before
    /// ([`crate::Impact`]).
    pub zone: Option<usize>,
}
