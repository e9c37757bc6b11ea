//! What a mechanism is, in lists of any length.

use moreau::{Body, Description, Dwell, Model, ModelError, Scalar, Site, Spring, Yields, Zone};

/// A mechanism before it is compiled into a model of fixed size. Indices count from 0; the ground is [`moreau::GROUND`].
#[derive(Debug, Clone)]
pub struct OwnedDescription<T = f64> {
    /// Bodies, parents first.
    pub bodies: Vec<Body<T>>,
    /// Torsion springs at their pivots.
    pub springs: Vec<Spring<T>>,
    /// Contact zones.
    pub zones: Vec<Zone<T>>,
    /// Dry friction that grows while it sticks.
    pub dwells: Vec<Dwell<T>>,
    /// Zones whose curves yield.
    pub yields: Vec<Yields<T>>,
    /// Where it is driven.
    pub site: Option<Site<T>>,
    /// Acceleration of gravity, m/s2, downward.
    pub gravity: T,
    /// Absolute angles from which it is let go, rad, one per body.
    pub angles: Vec<T>,
}

impl<T: Scalar> OwnedDescription<T> {
    /// As the engine takes it.
    pub fn borrowed(&self) -> Description<'_, T> {
        let OwnedDescription { bodies, springs, zones, dwells, yields, site, gravity, .. } = self;
        Description { bodies, springs, zones, dwells, yields, site: *site, gravity: *gravity }
    }

    /// The model in a given size.
    ///
    /// # Errors
    /// [`ModelError`]: it does not fit, or a number is not sound.
    pub fn model<const B: usize, const Z: usize>(&self) -> Result<Model<T, B, Z>, ModelError> {
        self.borrowed().compile()
    }

    /// The first angles in a given size; unused places are zero.
    pub fn first_angles<const B: usize>(&self) -> [T; B] {
        core::array::from_fn(|i| self.angles.get(i).copied().unwrap_or(T::ZERO))
    }
}

/// What is looked at after every step, beside the driven point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Marks {
    /// A point of a body, m in the body's frame.
    pub point: Option<(usize, [f64; 2])>,
    /// The zone that the point meets: instant and speed are taken from its flight before ([`crate::Meeting`]).
    pub zone: Option<usize>,
}
