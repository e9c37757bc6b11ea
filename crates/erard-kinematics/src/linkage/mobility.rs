//! Degrees of freedom, redundant constraints and free coordinates, from the rank of the Jacobian at a pose, with an
//! explanation in words.

use std::fmt;

use super::description::CoordinateId;
use super::equation::Axis;
use super::mechanism::{LinkageMechanism, Pose};

/// Vectors whose part outside the others is shorter than this (relative to the
/// longest) count as dependent. Poses are solved to 1e-14, and a pose within
/// 1e-8 rad of a singular one cannot be told from it; raising this to 1e-4 would
/// call poses singular that are only awkward.
const DEPENDENT: f64 = 1e-8;

/// Constraint that follows from others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Redundancy {
    /// A closure equation whose gradient at this pose is a combination of those of earlier equations.
    Equation {
        /// Number of the equation, from 1.
        equation: usize,
        /// Number of its loop, from 1.
        circuit: usize,
        /// Component of the loop's vector equation.
        axis: Axis,
        /// Name of the joint that closes the loop.
        chord: String,
        /// Numbers of the equations from which it follows.
        follows_from: Vec<usize>,
    },
    /// A prismatic joint whose constant angle other joints already enforce.
    Angle {
        /// Name of the joint.
        joint: String,
    },
}

/// Whether the prescribed coordinates and the constraints determine a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The prescribed coordinates determine all others.
    Determined,
    /// Some coordinates are free: prescribe more.
    UnderConstrained,
    /// More coordinates are prescribed than the linkage can follow: prescribe fewer.
    OverDriven,
    /// The number of prescribed coordinates is right, but at this pose they cannot be moved independently, while others
    /// are free: a dead centre.
    Singular,
}

/// Mobility of a mechanism at one pose. `Display` explains it in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mobility {
    /// Number of independent loops of the graph.
    pub loops: usize,
    /// Number of all coordinates, prescribed ones included.
    pub coordinates: usize,
    /// Rank of the Jacobian with respect to all coordinates.
    pub rank: usize,
    /// Grübler's count, 3 x moving bodies - 2 x joints. It does not notice special dimensions.
    pub grubler: isize,
    /// Number of coordinates minus rank: the true first-order mobility.
    pub degrees_of_freedom: usize,
    /// Constraints that follow from others (an over-constrained linkage has some).
    pub redundant: Vec<Redundancy>,
    /// Symbols of unknown coordinates that the prescribed ones leave free.
    pub free: Vec<String>,
    /// Symbols of prescribed coordinates that cannot be chosen independently of the others.
    pub excess: Vec<String>,
    /// Symbols of the prescribed coordinates.
    pub prescribed: Vec<String>,
}

impl Mobility {
    /// Returns which of the four cases applies.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match (self.free.is_empty(), self.excess.is_empty()) {
            (true, true) => Verdict::Determined,
            (false, true) => Verdict::UnderConstrained,
            (true, false) => Verdict::OverDriven,
            (false, false) => Verdict::Singular,
        }
    }

    /// Returns whether some constraints follow from others at this pose.
    #[must_use]
    pub fn over_constrained(&self) -> bool {
        !self.redundant.is_empty()
    }
}

/// For each vector in turn: `None` if it is independent of those before it, else
/// the factors with which it is made of them.
fn dependence(vectors: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let longest = vectors.iter().map(|v| norm(v)).fold(0.0, f64::max);
    // Orthonormal basis of what came so far, and each basis vector's recipe.
    let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    let mut found = Vec::with_capacity(vectors.len());
    for (i, vector) in vectors.iter().enumerate() {
        let mut rest = vector.clone();
        let mut recipe = vec![0.0; vectors.len()];
        // Twice: the second pass removes what rounding left of the first.
        for _ in 0..2 {
            for (direction, made_of) in &basis {
                let part: f64 = rest.iter().zip(direction).map(|(a, b)| a * b).sum();
                rest.iter_mut().zip(direction).for_each(|(r, d)| *r -= part * d);
                recipe.iter_mut().zip(made_of).for_each(|(r, m)| *r += part * m);
            }
        }
        let size = norm(&rest);
        if size <= DEPENDENT * longest {
            found.push(Some(recipe));
        } else {
            let mut made_of: Vec<f64> = recipe.iter().map(|r| -r / size).collect();
            made_of[i] = 1.0 / size;
            basis.push((rest.iter().map(|x| x / size).collect(), made_of));
            found.push(None);
        }
    }
    found
}

impl LinkageMechanism {
    /// Returns degrees of freedom, redundant equations, free and excess coordinates at `pose`. The pose should be a
    /// solved one: elsewhere redundant equations look independent.
    #[must_use]
    pub fn mobility(&self, pose: &Pose) -> Mobility {
        let n = self.coordinates().len();
        let jacobian = self.jacobian(pose);
        let rows: Vec<Vec<f64>> =
            if n == 0 { Vec::new() } else { jacobian.chunks_exact(n).map(<[f64]>::to_vec).collect() };
        let column = |id: CoordinateId| rows.iter().map(|row| row[id.0]).collect::<Vec<f64>>();
        let symbol = |id: CoordinateId| self.coordinates()[id.0].symbol.clone();

        let by_row = dependence(&rows);
        let mut redundant: Vec<Redundancy> = (self.repeated_angles().iter())
            .map(|joint| Redundancy::Angle { joint: self.linkage().joints[joint.0].name.clone() })
            .collect();
        for (i, recipe) in by_row.iter().enumerate() {
            let Some(recipe) = recipe else { continue };
            let equation = &self.equations()[i];
            let closure = &self.closures()[equation.circuit - 1];
            redundant.push(Redundancy::Equation {
                equation: equation.number,
                circuit: equation.circuit,
                axis: equation.axis,
                chord: self.linkage().joints[closure.chord.0].name.clone(),
                follows_from: (recipe.iter().enumerate())
                    .filter(|(_, factor)| factor.abs() > 1e-6)
                    .map(|(j, _)| self.equations()[j].number)
                    .collect(),
            });
        }
        // Backwards, so that of several equivalent choices the coordinate declared
        // first is called free, and the one prescribed last is called excess.
        let unknown: Vec<CoordinateId> = self.unknown().collect();
        let prescribed: Vec<CoordinateId> = self.prescribed().collect();
        let order: Vec<CoordinateId> = (unknown.iter().rev()).chain(prescribed.iter().rev()).copied().collect();
        let columns: Vec<Vec<f64>> = order.iter().map(|&id| column(id)).collect();
        let by_column = dependence(&columns);
        let mut free = Vec::new();
        let mut excess = Vec::new();
        for (i, (&id, recipe)) in order.iter().zip(&by_column).enumerate() {
            match recipe {
                Some(_) if i < unknown.len() => free.insert(0, symbol(id)),
                None if i >= unknown.len() => excess.insert(0, symbol(id)),
                _ => {}
            }
        }
        let rank = by_row.iter().filter(|recipe| recipe.is_none()).count();
        let signed = |n: usize| isize::try_from(n).expect("a linkage is small");
        Mobility {
            loops: self.closures().len(),
            coordinates: n,
            rank,
            grubler: 3 * signed(self.linkage().bodies.len() - 1) - 2 * signed(self.linkage().joints.len()),
            degrees_of_freedom: n - rank,
            redundant,
            free,
            excess,
            prescribed: prescribed.into_iter().map(symbol).collect(),
        }
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

impl fmt::Display for Redundancy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Redundancy::Equation { equation, circuit, axis, chord, follows_from } => {
                let axis = match axis {
                    Axis::X => "x",
                    Axis::Y => "y",
                };
                let from: Vec<String> = follows_from.iter().map(|n| format!("({n})")).collect();
                write!(f, "equation ({equation}), {axis} of loop {circuit} closed by `{chord}`, ")?;
                if from.is_empty() {
                    write!(f, "constrains nothing here")
                } else {
                    write!(f, "repeats what {} already say here", from.join(", "))
                }
            }
            Redundancy::Angle { joint } => {
                write!(f, "the constant angle of prismatic joint `{joint}` is already enforced by the others")
            }
        }
    }
}

impl fmt::Display for Mobility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} loop(s) give {} equations for {} coordinates; their Jacobian has rank {}, \
             so the linkage has {} degree(s) of freedom (Grübler's count: {}). ",
            self.loops,
            2 * self.loops,
            self.coordinates,
            self.rank,
            self.degrees_of_freedom,
            self.grubler,
        )?;
        for redundancy in &self.redundant {
            write!(f, "Over-constrained: {redundancy}. ")?;
        }
        let given = list(&self.prescribed);
        match self.verdict() {
            Verdict::Determined => write!(f, "Prescribed: {given}. This determines every pose."),
            Verdict::UnderConstrained => write!(
                f,
                "Under-constrained: with {given} prescribed, {} can still be chosen freely.",
                list(&self.free)
            ),
            Verdict::OverDriven => write!(
                f,
                "Over-driven: of the prescribed {given}, {} cannot be moved beside the others.",
                list(&self.excess)
            ),
            Verdict::Singular => write!(
                f,
                "Singular pose: {} cannot be moved freely here, while {} can move without it.",
                list(&self.excess),
                list(&self.free)
            ),
        }
    }
}
